# SPDX-License-Identifier: Apache-2.0
# A dry run and a plan open every file that a scene names, each frame's among them: what is missing, or of another kind, is
# said with its place.
say() { "$@" || echo "returns $?"; }
cat >scene.yaml <<'SCENE'
clouds:
  - {name: low, bake: {extent: 1 km, voxel: 100 m}, phase: isotropic}
output: {image: "a.####.exr"}
SCENE
nephos bake scene.yaml -q -o b.0001.vdb >/dev/null
cp b.0001.vdb b.0002.vdb
cp b.0001.vdb b.0004.vdb
imported='clouds=[{vdb: "b.####.vdb", extinction: 1, missing: error}]'
say nephos render scene.yaml -n --frames 1-4 --set "$imported"
say nephos render scene.yaml --explain --frames 3 --set "$imported"
say nephos render scene.yaml -n --frames 1-2 --set "$imported" --set 'clouds[0].reference_frame=5' \
  --set 'clouds[0].optical_depth=4'
mkdir b.0005.vdb
say nephos render scene.yaml -n --frames 5 --set "$imported"
echo 'no grid' >b.0006.vdb
say nephos render scene.yaml -n --frames 6 --set "$imported" 2>&1 | sed 's/vdb: .*/vdb: .../'
say nephos render scene.yaml -n --set 'clouds=[{vdb: b.0001.vdb, grid: smoke, extinction: 1}]'
say nephos render scene.yaml -n --set 'clouds=[{vdb: b.0001.vdb, extinction: 1, emission: {}}]'
say nephos render scene.yaml -n --set 'clouds[0].phase={table: phase.csv}'
say nephos render scene.yaml -n --set 'clouds[0].bake.map={image: map.png, coverage: R}'
say nephos bake scene.yaml -n --set 'clouds[0].bake.map={image: map.png, coverage: R}'
echo 'angle_deg,value' >phase.csv
say nephos render scene.yaml -n --set 'clouds[0].phase={table: phase.csv}'
cat >>scene.yaml <<'SCENE'
terrain:
  heightfield: hills.png
SCENE
say nephos render scene.yaml -n
echo 'no picture' >hills.png
say nephos render scene.yaml -n
say nephos render scene.yaml -n --set terrain.heightfield=hills.hgt
echo 'too short' >N44W072.hgt
say nephos render scene.yaml -n --set terrain.heightfield=N44W072.hgt
say nephos render scene.yaml -n --set terrain=none --set 'place={latitude: 0, longitude: 0}' \
  --set 'stars={sidereal_time: 0, catalogue: stars.csv}'
say nephos sky scene.yaml -n -o sky.exr --set terrain=none --set 'place={latitude: 0, longitude: 0}' \
  --set 'stars={sidereal_time: 0, map: stars.exr}'
say nephos render scene.yaml -n --set terrain=none --set 'moon={elevation: 9, azimuth: 9, map: moon.exr}'
