# SPDX-License-Identifier: Apache-2.0
# Nobody reads what is printed any more: the work ends as if interrupted, with no message and nothing left.
cat >scene.yaml <<'YAML'
camera: {resolution: [1024, 1024]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
render: {integrator: march, samples: 4096}
YAML
(
  env --default-signal=PIPE nephos render scene.yaml --progress json -o a.exr 2>&1 >/dev/null || echo "exit $?" >code
) | head -n 1 | grep -c stage
cat code
ls -A
