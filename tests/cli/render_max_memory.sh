# SPDX-License-Identifier: Apache-2.0
# A render that may need more memory than allowed is refused before it begins, as is its dry run; with enough it runs
# within it. Without sanitizers, whose memory counts.
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

# A file that is denser than its header tells: its light is held to what is left of the limit.
ln -s "$(dirname "$0")/../data" data
cat >dense.yaml <<'YAML'
camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 1300 m], resolution: [32, 18]}
atmosphere: none
clouds: [{vdb: data/vdb/zipmask_half.vdb, extinction: 1 1/m, voxel: 50 m, position: [0, 0, 800 m]}]
render: {samples: 1}
output: {image: d.exr}
YAML
nephos render dense.yaml --max-memory 0.1 -q --json 2>message | grep -o '"memory_bytes": [0-9]*' |
  awk '{print ($2 < 1e8 ? "within" : "above")}'
sed 's/on [0-9.]* of [0-9.]* million/on N of M million/' message >&2

# A bake's cells with cloud are counted before: where they fit, all are solved for, without a warning.
cat >fits.yaml <<'YAML'
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg, resolution: [32, 18]}
atmosphere: none
clouds: [{bake: {preset: cumulus_mediocris, seed: 7, extent: 4 km, base: 1800 m, voxel: 40 m}}]
render: {samples: 1}
output: {image: e.exr}
YAML
nephos render fits.yaml --max-memory 0.09 -q --json | grep -o '"memory_bytes": [0-9]*' |
  awk '{print ($2 < 9e7 ? "within" : "above")}'
