# SPDX-License-Identifier: Apache-2.0
# Signals that end the work end it cleanly, unless they were ignored from the start. A shell ignores SIGINT for what it runs
# in the background.
cat >long.yaml <<'YAML'
camera: {resolution: [1024, 1024]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
render: {integrator: march, samples: 4096}
YAML
start() {
  : >messages
  "$@" --progress lines -o a.exr 2>messages &
  until grep -qs rendering messages; do sleep 0.02; done
}
for signal in INT TERM HUP; do
  start env --default-signal=INT,TERM,HUP nephos render long.yaml
  kill -$signal $!
  wait $! || echo "$signal: exit $?"
  ls -A
done
trap '' HUP
start nephos render long.yaml --resolution 64x36 --samples 1024
kill -HUP $! 2>/dev/null || true
wait $! && echo "ignored HUP: exit $?"
ls -A
