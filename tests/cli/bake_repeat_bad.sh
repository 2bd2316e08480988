# SPDX-License-Identifier: Apache-2.0
# Bakes that cannot repeat: a check, a dry run, a render and a bake refuse them alike.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_humilis, extent: 4 km, voxel: 200 m, repeat: 4 km, wind: [10 m/s, 5 m/s]}}
END
try() {
  nephos check scene.yaml --set "clouds[0].bake.$1" || echo "check: exit $?"
  nephos render scene.yaml -n -q -o a.exr --set "clouds[0].bake.$1" || echo "dry run: exit $?"
  nephos render scene.yaml -q -o a.exr --resolution 8x8 --set "clouds[0].bake.$1" || echo "render: exit $?"
  nephos bake scene.yaml -q -o a.vdb --set "clouds[0].bake.$1" || echo "bake: exit $?"
}
try 'wind_speed=[10 m/s, 5 m/s, 5 m/s, 5 m/s, 5 m/s]'
try 'extent=[4 km, 5 km]'
try 'precipitation=0.5'
try 'model=fog'
ls
