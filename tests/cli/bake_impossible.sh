# SPDX-License-Identifier: Apache-2.0
# Bakes that a render cannot make: a measured map that is no raster, and a box of too many voxels. A check and a dry run
# refuse both as the render does.
cat >scene.yaml <<'END_OF_SCENE'
clouds:
  - {name: low, bake: {preset: stratocumulus, extent: 4 km, voxel: 200 m}}
END_OF_SCENE
echo "no raster" >map.tif
try() {
  nephos check scene.yaml --set "clouds[0].bake.$1" || echo "check: exit $?"
  nephos render scene.yaml -n -q -o a.exr --set "clouds[0].bake.$1" || echo "dry run: exit $?"
  nephos render scene.yaml -q -o a.exr --resolution 8x8 --set "clouds[0].bake.$1" || echo "render: exit $?"
}
try 'map={file: map.tif, quantity: optical_depth}'
try 'voxel=200 mm'
ls
