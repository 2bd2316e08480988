# SPDX-License-Identifier: Apache-2.0
# A cloud's file is baked where there is none, left alone while it holds the scene's cloud, and baked anew when not.
cat >scene.yaml <<'END'
camera: {position: [0, -2 km, 1500 m], look_at: [0, 0, 1300 m], resolution: [8, 4]}
atmosphere: none
environment: {radiance: 0.1}
clouds:
  - {name: low, vdb: low.####.vdb, bake: {preset: cumulus_humilis, seed: 1, extent: 1 km, voxel: 50 m, coverage: 0.8}}
render: {samples: 1, multiple_scattering: none}
output: {image: frame.exr}
END
explain() { nephos render scene.yaml --explain "$@" | grep '^volumes'; }
look() { nephos render scene.yaml -q -o look.exr "$@" >>log; stat -c %y low.0001.vdb; }
explain
look >first
explain
look >second
cmp first second
explain --set clouds[0].bake.seed=2
look --set clouds[0].bake.seed=2 >third
cmp -s first third || echo other bytes
look --set clouds[0].bake.seed=2 >fourth
cmp third fourth
nephos bake -q --verify low.0001.vdb
# another tool's file is nobody's to replace, and a damaged one is an error
echo nonsense >low.0001.vdb
nephos render scene.yaml --explain || echo $?
cat low.0001.vdb
