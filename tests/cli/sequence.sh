# SPDX-License-Identifier: Apache-2.0
# Imported sequences: the reference frame is named, and a frame that holds nothing renders empty, with a warning.
cat >bake.yaml <<'SCENE'
clouds: [{bake: {extent: 1 km, voxel: 100 m, coverage: 1}}]
SCENE
nephos bake bake.yaml -q -o b.0002.vdb >/dev/null
nephos bake bake.yaml -q -o b.0001.vdb --set 'clouds[0].bake.coverage=0' >/dev/null
cp b.0002.vdb b.0003.vdb
cat >scene.yaml <<'SCENE'
camera: {resolution: [16, 9]}
atmosphere: none
clouds: [{name: low, vdb: "b.####.vdb", position: [0, 0, 1 km], optical_depth: 10}]
render: {samples: 1}
output: {image: "a.####.exr"}
SCENE
nephos render scene.yaml --explain --frames 1-2 | grep reference
nephos render scene.yaml --explain --frames 3 --set 'clouds[0].reference_frame=2' | grep reference
nephos render scene.yaml --explain --frames 3 --json | grep -A 5 reference_frames
nephos render scene.yaml --quiet --frames 1-3
nephos render scene.yaml --progress none --frames 3 --set 'clouds[0].reference_frame=2' -o alone.exr 2>&1 |
  grep 'reference frame'
nephos compare --exact alone.exr a.0003.exr >compared
sed 1,3d compared
nephos render scene.yaml --quiet --frames 2 --set 'clouds[0].reference_frame=1'
