# SPDX-License-Identifier: Apache-2.0
# An output that is another output, or an input, is refused before anything is written.
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
output: {image: a.exr}
YAML
refused() { nephos "$@" -q >out || echo "exit $?"; [ ! -s out ] || cat out; }
untouched() { # FILE: is as it was
  [ "$(cat "$1")" = "as it was" ] || echo "$1 has changed"
}

echo "== two outputs of a frame"
mkdir -p folder
ln -s a.exr link.png
refused render scene.yaml --set output.preview=link.png
refused render scene.yaml -n --set output.preview=link.png
refused render scene.yaml --set output.deep=folder/../a.exr
refused render scene.yaml --set output.deep=./a.exr --frames 1-2 --set output.image=a.0002.exr --set output.deep=a.####.exr
refused render scene.yaml --set output.image=a.snapshot.exr --set output.preview=a.snapshot.exr.png \
  --set output.deep=a.snapshot.snapshot.exr
refused render scene.yaml -o log.npart --log log.npart
ls
printf 'as it was' >kept.exr
ln kept.exr hard.exr
refused render scene.yaml --set output.image=kept.exr --set output.deep=hard.exr
untouched kept.exr

echo "== an output and an input"
cp scene.yaml copy.yaml
ln -s scene.yaml scene.exr
refused render scene.yaml -o scene.exr
cmp scene.yaml copy.yaml
printf 'as it was' >weather.0001.png
refused render scene.yaml --set 'clouds=[{bake: {extent: 1 km, map: {image: weather.0001.png, coverage: R}}}]' \
  -o 'weather.####.png'
untouched weather.0001.png
printf 'as it was' >smoke.0007.vdb
ln smoke.0007.vdb b.0002.exr
refused render scene.yaml --set 'clouds=[{vdb: smoke.####.vdb, optical_depth: 1}]' --frames 1-3 -o 'b.####.exr'
untouched smoke.0007.vdb
for kind in bake: export:; do
  printf 'as it was' >weather.png
  ln -sf weather.png cloud.vdb
  refused ${kind%:} scene.yaml --set 'clouds=[{bake: {extent: 1 km, map: {image: weather.png, coverage: R}}}]' -o cloud.vdb
  untouched weather.png
done
refused export scene.yaml --set 'clouds=[{vdb: smoke.0007.vdb, optical_depth: 1}]' -o smoke.0007.vdb
untouched smoke.0007.vdb

printf 'as it was' >own.lod1.vdb
refused export scene.yaml --set 'clouds=[{vdb: own.lod1.vdb, optical_depth: 1}]' -o own.vdb --levels 2
untouched own.lod1.vdb
ln -s weather.png field.lod1.vdb
refused bake scene.yaml --set 'clouds=[{bake: {extent: 1 km, levels: 2, map: {image: weather.png, coverage: R}}}]' \
  -o field.vdb
refused render scene.yaml --set 'clouds=[{vdb: field.vdb, bake: {extent: 1 km, levels: 2, map: {image: weather.png, coverage: R}}}]'
untouched weather.png
rm field.lod1.vdb
refused bake scene.yaml --set 'clouds=[{name: a, vdb: f.vdb, bake: {extent: 1 km, levels: 2}}, {name: b, vdb: f.lod1.vdb, bake: {extent: 1 km}}]'
printf 'as it was' >levels.vdb
printf 'as it was' >levels.lod1.vdb
refused bake scene.yaml --set 'clouds=[{vdb: levels.vdb, optical_depth: 1}, {bake: {extent: 1 km}}]' -o levels.lod1.vdb
untouched levels.lod1.vdb
printf 'as it was' >baked.vdb
refused export scene.yaml --set 'clouds=[{vdb: baked.vdb, bake: {extent: 1 km}}]' -o baked.vdb
untouched baked.vdb

mkdir report
printf 'x_m,y_m,z_m\n0,0,1000\n' >report/report.csv
cp report/report.csv before
refused report scene.yaml --quick --budget 1s -o report --set 'clouds=[{bake: {extent: 1 km}, places: report/report.csv}]'
cmp report/report.csv before
ls report

echo "== merge, compare, sky, probe, check"
nephos render scene.yaml -q -o 1.npart --tile 1/2 >out
nephos render scene.yaml -q -o 2.npart --tile 2/2 >out
cp 1.npart before
ln -s 1.npart merged.exr
refused merge 1.npart 2.npart -o merged.exr
cmp 1.npart before
rm merged.exr
nephos merge 1.npart 2.npart -o merged.exr >out
cp merged.exr before
refused compare merged.exr ./merged.exr -o folder/../merged.exr
cmp merged.exr before
ln -s sky.exr sky.usda
refused sky scene.yaml -o sky.exr --usd sky.usda
printf 'as it was' >slab.csv
ln -s slab.csv answer.csv
refused probe slab slab.csv -o answer.csv
untouched slab.csv
refused check smoke.0007.vdb --fix -o smoke.0007.vdb
untouched smoke.0007.vdb
nephos check scene.yaml --set output.deep=a.exr || echo "exit $?"

echo "== a log"
for file in scene.yaml merged.exr; do
  cp $file before
  refused info scene.yaml --log $file
  cmp $file before
done
nephos info scene.yaml --log new.log >out
nephos info scene.yaml --log new.log >out
wc -l <new.log

echo "== light beside a checkpoint"
refused render scene.yaml --checkpoint 60s --log a.npart.light0-0
rm -f a.npart.light0-0
ln -s weather.png a.npart.light2-1
refused render scene.yaml --resume --set 'clouds=[{bake: {extent: 1 km, map: {image: weather.png, coverage: R}}}]'
untouched weather.png
rm a.npart.light2-1
ln -s p.npart.light0-0 p.exr
refused render scene.yaml -o p.npart --resume --set output.deep=p.exr
rm p.exr

echo "== files of their own"
nephos render scene.yaml -q --set output.preview=a.png --checkpoint 60s >out
nephos render scene.yaml -q --frames 1-3 -o 'a.####.exr' -o 'a.####.png' >out
nephos render scene.yaml -q -o part.npart --resume >out
ls a.*
refused render scene.yaml -o deep.exr --set output.deep=deep.exr
