# SPDX-License-Identifier: Apache-2.0
# A render that may need more memory than allowed is refused before it begins, as is its dry run; with enough it runs.
cat >scene.yaml <<'YAML'
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 129}}
output: {image: a.exr}
YAML
nephos render scene.yaml --max-memory 0.01 || echo "exit $?"
nephos render scene.yaml --max-memory 0.01 -q --dry-run || echo "exit $?"
ls
nephos render scene.yaml --max-memory 1 -q >/dev/null && ls
cat >cloud.yaml <<'YAML'
camera: {resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
clouds: [{precision: float, bake: {extent: 3 km, voxel: 40 m, model: hero}}]
render: {samples: 1}
output: {image: b.exr}
YAML
nephos render cloud.yaml --max-memory 0.03 -q >/dev/null && nephos info b.exr | grep memorySavings
nephos render cloud.yaml --max-memory 0.0142 -q || echo "exit $?"
