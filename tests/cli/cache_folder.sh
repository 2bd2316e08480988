# SPDX-License-Identifier: Apache-2.0
# The folder of the cache is nephos's own: made with its parents, never mixed with files of others, and none of its
# entries can hang a render.
cat >scene.yaml <<'Y'
version: 1
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg, resolution: [8, 6]}
atmosphere: none
clouds: [{name: field, bake: {preset: cumulus_humilis, seed: 7, base: 1800 m, voxel: 200 m, extent: 2 km}}]
terrain: {ridges: {samples: 33}}
render: {samples: 1}
Y
quietly() { timeout -k 1 60 nephos render scene.yaml -q -t 1 "$@" >/dev/null; }
without_keys() { sed 's/-[0-9a-f]\{32\}//'; }
same() { nephos compare --exact -q "$1" "$2" >/dev/null && echo "$1 is $2"; }
quietly -o alone.exr

echo 'parents are made'
umask 077
quietly --cache deep/er/folder -o deep.exr
ls -ld deep deep/er/folder/nephos-cache deep/er/folder/nephos-cache/bake-*.cache | cut -c1-10

echo 'files of others stay'
mkdir D
head -c 2000000 /dev/zero >D/mine.cache
head -c 3000000 /dev/zero >D/bake-00112233445566778899aabbccddeeff.cache
touch -d 2020-01-01 D/*.cache
quietly --cache D --cache-size 0.004 -o others.exr
touch -d 2020-01-01 D/nephos-cache/CACHEDIR.TAG
head -c 5000000 /dev/zero >D/nephos-cache/mine.cache
quietly --cache D --cache-size 0.004 -o others.exr
ls D D/nephos-cache | grep -e mine -e TAG -e 0011

echo 'a folder of that name without the tag is left as it is'
mkdir -p E/nephos-cache
echo text >E/nephos-cache/bake-00112233445566778899aabbccddeeff.cache
quietly --cache E -o no.exr || echo $?
ls E/nephos-cache | without_keys
mkdir F && ln -s ../D/nephos-cache F/nephos-cache
quietly --cache F -o no.exr || echo $?

echo 'pipes, links and folders in place of entries'
P=deep/er/folder/nephos-cache
for make in mkfifo mkdir 'ln -s ../../../scene.yaml' 'ln -s nowhere'; do
  for n in "$P"/*.cache; do rm -r "$n" && $make "$n"; done
  rm -f "$P/.lock" && mkfifo "$P/.lock"
  quietly --cache deep/er/folder -o again.exr 2>err || echo "$make: $?"
  without_keys <err | sort -u
  same again.exr alone.exr
  rm -rf "$P"/*.cache
  quietly --cache deep/er/folder -o again.exr
done
head -n 1 scene.yaml

echo 'a pipe in place of a light checkpoint'
mkfifo c.npart.light0-0
quietly --checkpoint 1h --resume -o c.exr || echo $?
same c.exr alone.exr
