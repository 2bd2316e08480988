# SPDX-License-Identifier: Apache-2.0
# All files that are missing are told at once, each once; a cloud is placed by all of its places.
cat >missing.yaml <<'YAML'
clouds:
  - {name: a, vdb: a.vdb, extinction: 1 1/m}
  - {name: b, vdb: b.vdb, extinction: 1 1/m}
terrain: {heightfield: hills.hgt}
output: {image: x.exr}
YAML
nephos check missing.yaml || echo "exit $?"
nephos render missing.yaml -n || echo "exit $?"
cat >without_camera.yaml <<'YAML'
camera: {motion: {file: none.chan}}
clouds: [{bake: {extent: 1 km}, phase: {table: none.csv}}]
terrain: {heightfield: hills.hgt}
output: {image: x.exr}
YAML
nephos check without_camera.yaml || echo "exit $?"
cat >field.yaml <<'YAML'
clouds: [{bake: {model: hero, extent: 600 m, voxel: 30 m}}]
YAML
nephos bake field.yaml -q -o cloud.vdb
printf 'x_m,y_m,z_m\n0,-90000,1000\n0,-91000,1000\n' >behind.csv
cat >behind.yaml <<'YAML'
camera: {position: [0 m, -3 km, 500 m], look_at: [0 m, 0 m, 500 m]}
clouds: [{name: copies, vdb: cloud.vdb, extinction: 0.1 1/m, places: behind.csv}]
output: {image: x.exr}
YAML
nephos check behind.yaml || echo "exit $?"
cat >folders.yaml <<'YAML'
clouds: [{name: a, vdb: nowhere/a.vdb, bake: {model: hero, extent: 600 m, voxel: 30 m}}]
output: {image: nowhere/x.exr, preview: cloud.vdb/x.png, deep: deep.exr}
YAML
nephos check folders.yaml || echo "exit $?"
