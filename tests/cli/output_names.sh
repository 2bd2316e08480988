# SPDX-License-Identifier: Apache-2.0
# Names that no file can have, files of the cache and previews of no colour are refused before the first pixel.
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
clouds: [{bake: {extent: 1 km, voxel: 100 m, preset: cumulus_humilis}}]
output: {image: a.exr}
YAML
refused() { # what is printed, names of one letter cut short
  nephos "$@" -q 2>err >out || echo "exit $?" >>err
  cat out
  sed -E 's/(n{9})n+/\1~/g' err
}
long=$(printf 'n%.0s' $(seq 300))
most=$(printf 'n%.0s' $(seq 251)).exr

echo '== names'
refused render scene.yaml -o "$long.exr"
refused render scene.yaml -n -o "$long.exr"
refused render scene.yaml -n --set "output.deep=$long.exr"
refused render scene.yaml -n --set "output.preview=$long.png"
refused render scene.yaml -n --set "clouds[0].vdb=$long.vdb"
refused render scene.yaml -n -o "$most" --checkpoint 60s
refused check scene.yaml --set "output.image=$long.exr"
refused check scene.yaml --set "clouds[0].vdb=$long.vdb"
refused bake scene.yaml -n -o "$long.vdb"
refused export scene.yaml -n -o "$long.vdb"
refused sky scene.yaml -o "$long.exr"
refused info scene.yaml --log "$long.log"
ls

echo '== the longest name'
nephos render scene.yaml -q -n -o "$most" | wc -c
nephos render scene.yaml -q -o "$most" >out
nephos render scene.yaml -q -o "$most" >out # replaces it
ls -A | grep -c nnn

echo '== the cache'
nephos render scene.yaml -q --cache cache -o a.exr >out
cp cache/nephos-cache/CACHEDIR.TAG tag
ln -s cache/nephos-cache/CACHEDIR.TAG link.exr
ln -s cache/nephos-cache folder
refused render scene.yaml --cache cache -o link.exr
refused render scene.yaml --cache cache -n -o link.exr
refused render scene.yaml -n -o cache/nephos-cache/x.exr
refused render scene.yaml -n -o folder/x.exr
refused render scene.yaml -n -o x.exr --log cache/nephos-cache/.lock
refused check scene.yaml --set output.image=folder/x.exr
refused bake scene.yaml -n -o folder/x.vdb
refused export scene.yaml --usd folder/x.usda
refused report scene.yaml --quick --budget 1s -o folder
cmp cache/nephos-cache/CACHEDIR.TAG tag
ls -A folder | sed 's/-[0-9a-f]\{32\}//'

echo '== a log'
mkfifo pipe
refused info scene.yaml --log pipe
nephos info scene.yaml -q --log /dev/full >out

echo '== a preview without colour'
refused render scene.yaml -n -o x.png --set output.beauty=false --set 'output.aovs=[depth]'
refused check scene.yaml --set output.preview=x.png --set output.beauty=false --set 'output.aovs=[depth]'
