# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m, coverage: 0.8,
                      wind: [5 m/s, 0], frame_time: 10 s}}
END
nephos bake scene.yaml -q --frames 1-3x2 --half --levels 2 --prune 0.001 >/dev/null
ls
nephos bake -q --verify low.0003.vdb
nephos info low.0001.vdb | grep -c density_2
nephos bake scene.yaml -q --frames 1,2 -o one.vdb || echo $?
nephos bake scene.yaml -q --max-memory 0.001 || echo $?
