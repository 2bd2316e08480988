# SPDX-License-Identifier: Apache-2.0
# Standard streams that are closed: no file takes their numbers, so that nothing else goes into one. What is to be read
# from them or written to them fails; messages are lost.
cat >scene.yaml <<'YAML'
clouds:
  - {name: low, bake: {preset: cumulus_mediocris, seed: 7, extent: 2 km, voxel: 40 m}}
YAML
# Large enough that the bar is drawn while the file is written: a sheet has many voxels that are baked in little time.
large='--set clouds[0].bake.preset=altostratus --set clouds[0].bake.voxel=10m'
check() { nephos bake --verify low.vdb -q && rm low.vdb; }
nephos bake scene.yaml $large --progress bar 2>&-
check
nephos bake scene.yaml $large --progress bar <&- >&- 2>&- || echo "neither output nor messages: exit $?"
check
nephos bake scene.yaml -q >&- || echo "no output: exit $?"
check
nephos info - <&- || echo "no input: exit $?"
ls -A
