# SPDX-License-Identifier: Apache-2.0
# Variables, and literal signs, in names of files of scenes.
cat >scene.yaml <<END
version: 1
camera: {resolution: [16, 9]}
output: {image: "~/out.exr", preview: "\${NAME}/\$STEM.####.png"}
END
export HOME="$PWD/home" NAME=previews STEM=shot
mkdir home previews
names() { nephos render "$@" -n | sed "s|$PWD|FOLDER|"; }
names scene.yaml
names scene.yaml --set 'output={image: "a$#1.####.exr", preview: "take$$5.png"}'
names scene.yaml --set 'output={image: "$#$#.exr"}'
names scene.yaml --set 'output={image: "a_$F4.exr", preview: "a$.$1.png"}' --frames 12
STEM=shot.#### names scene.yaml --set 'output={image: "$STEM.exr"}' --frames 7
names scene.yaml -o 'b$#2.exr'
nephos render scene.yaml -q --samples 1 --set 'output={image: "~/a$#1.exr"}' | sed "s/,.*//; s|$PWD|FOLDER|"
ls home

# Inputs: a cloud, its sequence, and a table, whose names have the signs.
nephos bake scene.yaml -q --set 'clouds=[{bake: {preset: fog, extent: 500 m, voxel: 50 m}, vdb: "fog$#1.vdb"}]' |
  sed 's/,.*//'
cp 'fog#1.vdb' 'fog#1.0003.vdb'
printf 'x_m,y_m,z_m\n0,0,0\n' >'places#1.csv'
for cloud in 'vdb: "fog$#1.vdb", extinction: 1' 'vdb: "fog$#1.####.vdb", extinction: 1, missing: hold' \
  'vdb: "fog$#1.vdb", extinction: 1, places: "places#1.csv"' \
  'vdb: "fog$#1.vdb", extinction: 1, places: "places$#1.csv"'; do
  nephos render scene.yaml -q --samples 1 -o a.exr --set "clouds=[{$cloud}]" 2>&1 | sed 's/,.*//'
done
nephos check scene.yaml --set 'clouds=[{vdb: "fog$#1.vdb", extinction: 1}]' 2>/dev/null | tail -n 1

# Refusals, each with the place of the value.
for name in '$UNSET/a.exr' '${UNSET}.exr' '~other/a.exr' '${}.exr' '${HOME' '${A-b}.exr'; do
  sed "s|~/out.exr|$name|" scene.yaml >wrong.yaml
  nephos info wrong.yaml || echo "exit $?"
done
NAME= nephos info scene.yaml || echo "exit $?"
nephos info scene.yaml --set 'moon.map=$UNSET.exr' || echo "exit $?"
