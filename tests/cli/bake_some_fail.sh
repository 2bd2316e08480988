# SPDX-License-Identifier: Apache-2.0
# A frame that cannot be baked lets the others go on, and the end says which failed: a picture of a sequence is missing,
# or damaged. A frame alone fails as such.
picture="$(dirname "$0")/../data/weather_box.png"
for frame in 1 3 5; do cp "$picture" w.000$frame.png; done
echo damaged >w.0004.png
cat >scene.yaml <<'YAML'
version: 1
clouds: [{name: low, bake: {extent: 1 km, voxel: 50 m, map: "w.####.png"}}]
YAML
bake() { nephos bake scene.yaml -q "$@" >printed || echo "exit code $?"; }
bake --frames 1-5 -o a.####.vdb 2>errors
sed 's/\(w.0004.png: \).*/\1.../' errors
ls a.*
bake --frames 1-3 -o b.####.vdb --json 2>/dev/null
cut -d, -f1,2 printed
bake --frames 2 -o c.vdb 2>/dev/null
ls c.* 2>/dev/null || echo 'no file'
