# SPDX-License-Identifier: Apache-2.0
# A frame that fails is reported, the rest of the batch goes on, and the end says which are missing; what cannot be
# written ends the batch, since the rest could not be either.
cat >bake.yaml <<'SCENE'
clouds: [{bake: {extent: 1 km, voxel: 100 m, coverage: 1}}]
SCENE
nephos bake bake.yaml -q -o b.0001.vdb >/dev/null
for frame in 3 5; do cp b.0001.vdb b.000$frame.vdb; done
echo damaged >b.0002.vdb
cat >scene.yaml <<'SCENE'
camera: {resolution: [16, 9]}
atmosphere: none
clouds: [{vdb: "b.####.vdb", extinction: 1, missing: error}]
render: {samples: 1}
output: {image: "a.####.exr"}
SCENE
nephos render scene.yaml -q --frames 1-5 | sed 's/, [0-9].*//'
nephos render scene.yaml -q --frames 1-5 >/dev/null 2>&1 || echo "exit $?"
ls a.*
nephos render scene.yaml -q --frames 2-3 --json 2>/dev/null | cut -d, -f1,2
nephos render scene.yaml -q --frames 1-4 -n || echo "exit $?"
nephos render scene.yaml -q --frames 2 || echo "exit $?"
(ulimit -f 1 && nephos render scene.yaml -q --frames 1-5x2 --resolution 320x180 --samples 1 || echo "exit $?")
