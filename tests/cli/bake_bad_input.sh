# SPDX-License-Identifier: Apache-2.0
# Sizes and shares that cannot be, and voxels that no memory holds.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m, coverage: 0.8}}
END
try() { nephos bake scene.yaml -q "$@" || echo "exit $?"; }
try --set 'clouds[0].bake.voxel=0 m'
try --set 'clouds[0].bake.voxel=-5 m'
try --set 'clouds[0].bake.extent=[1 km, -1 km]'
try --set 'clouds[0].bake.thickness=0 m'
try --set 'clouds[0].bake.coverage=1.01'
try --set 'clouds[0].bake.coverage=-0.1'
try --set 'clouds[0].bake.coverage=nan'
try --set 'clouds[0].bake.profile=[0, 0.5, 0.4, 0.8, 1]'
try --set 'clouds[0].bake.voxel=1 mm'
try --prune -1
try --levels 9
try --region 0,0,0,1,1
try --region 1e6,0,0,2e6,1e3,1e3
try --max-memory 0
ls
