# SPDX-License-Identifier: Apache-2.0
# The weather map from above: written before the bake, named by a dry run, refused without a map and by a wrong name.
cp "$(dirname "$0")/../data/weather_box.png" weather.png
cat >scene.yaml <<'YAML'
clouds:
  - {name: low, bake: {extent: [4 km, 2 km], voxel: 100 m, wind: [10 m/s, 0 m/s], map: weather.png, frame_time: 60 s}}
  - {name: bare, bake: {model: fog, extent: 1 km, voxel: 100 m}}
YAML
bake() { nephos bake scene.yaml -q "$@" || echo "exit $?"; }
one='clouds=[{name: low, bake: {extent: 1 km, voxel: 100 m, map: {image: weather.png, type: Y}}}]'

echo "== a dry run"
bake -n --preview-map map.png
ls

echo "== a picture, and one for each frame"
bake --preview-map map.png
nephos info map.png
bake --preview-map . --frames 1-2 --json | grep map_preview
bake --preview-map map.png --set "$one" -o low.vdb
ls ./*.png

echo "== refused"
rm -f ./*.vdb map.png
bake --preview-map map.exr
bake --preview-map map.png --frames 1-2
bake --preview-map no/map.png
bake --preview-map weather.png
bake --preview-map a.png --set 'clouds=[{name: low, bake: {extent: 1 km, voxel: 100 m}}]'
bake --preview-map a.png --set 'clouds[0].bake.map=gone.png'
bake --preview-map a.png --set 'clouds[1].bake.map=weather.png'
bake -n --preview-map log.png --log log.png
ls
