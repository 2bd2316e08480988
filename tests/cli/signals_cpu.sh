# SPDX-License-Identifier: Apache-2.0
# SIGXCPU, which a limit on CPU time sends, saves a checkpoint as SIGTERM does; every second of CPU time after the first
# one too, while the checkpoint is written.
cat >long.yaml <<'YAML'
camera: {resolution: [160, 90]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
render: {integrator: march, samples: 1048576}
YAML
nephos render long.yaml --checkpoint 1h -o a.exr --progress lines 2>messages &
until grep -qs rendering messages; do sleep 0.02; done
kill -XCPU $!
wait $! || echo "kill: exit $?"
ls a.*
grep -o 'stopped by .*' messages
rm a.npart
(ulimit -S -t 2 && nephos render long.yaml --checkpoint 1h -o a.exr --progress lines 2>messages) || echo "ulimit: exit $?"
ls a.*
nephos render long.yaml --resume -o a.exr --samples 1 -q >/dev/null 2>messages && ls a.*
