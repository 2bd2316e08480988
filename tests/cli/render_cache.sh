# SPDX-License-Identifier: Apache-2.0
# Light, bakes and mountains on disk: same bits, no solving after a move of the camera, and nothing that can break them does.
cat >scene.yaml <<'Y'
version: 1
camera: {position: [0 m, -2 km, 900 m], look_at: [0, 0, 1000 m], fov: 40 deg, resolution: [32, 18]}
clouds: [{name: one, bake: {preset: cumulus_humilis, model: cells, extent: 1600 m, voxel: 80 m, coverage: 0.6}}]
atmosphere: {tolerance: 0.1}
terrain: {ridges: {samples: 65, relief: 300 m}, width: 20 km}
render: {samples: 1, sun_optical_depth: volume}
Y
moved='--set camera.position=[30m,-2km,900m]'
quietly() { nephos render scene.yaml -q "$@" >/dev/null; }
stages() { nephos render scene.yaml -v --cache c "$@" 2>&1 | grep -E '^nephos: (terrain|cloud one|sun optical depth|multiple scattering): (built|read)'; }
same() { nephos compare --exact -q "$1" "$2" >/dev/null && echo "$1 is $2"; }
quietly -o alone.exr
quietly $moved -o moved_alone.exr

echo 'cold, warm, and from elsewhere'
stages -o cold.exr
stages -o warm.exr
stages $moved -o moved.exr
same cold.exr alone.exr
same warm.exr alone.exr
same moved.exr moved_alone.exr
ls c c/nephos-cache | sed 's/-[0-9a-f]\{32\}.*//' | sort -u

echo 'tiles share what is gathered of the light'
for tile in 1 2; do
  nephos render scene.yaml -v --cache c --tile $tile/2 -o tile$tile.exr 2>&1 | grep -E '^nephos: (light to camera|clouds on ground): (built|read)'
done
nephos merge tile1.exr tile2.exr -o tiles.exr
same tiles.exr alone.exr

echo 'another sun'
stages --set sun.elevation=20deg -o sun.exr

echo 'damaged'
for n in c/nephos-cache/*.cache; do head -c 4000 "$n" >cut && mv cut "$n"; done
quietly --cache c -o cut.exr 2>err && sed 's/-[0-9a-f]\{32\}//' err | sort -u
same cut.exr alone.exr
for n in c/nephos-cache/*.cache; do printf x | dd of="$n" bs=1 seek=3000 conv=notrunc 2>dd.err; done
quietly --cache c -o flipped.exr 2>err && sed 's/-[0-9a-f]\{32\}//' err | sort -u
same flipped.exr alone.exr
for n in c/nephos-cache/*.cache; do : >"$n"; done
quietly --cache c -o empty.exr 2>err && sed 's/-[0-9a-f]\{32\}//' err | sort -u
same empty.exr alone.exr

echo 'two at once, and some that are killed'
rm -rf c
nephos render scene.yaml -v --cache c -o first.exr >first.log 2>&1 &
nephos render scene.yaml -v --cache c -o second.exr >second.log 2>&1
wait
echo "solved $(cat first.log second.log | grep -c 'residual.*sweeps') time"
same first.exr alone.exr
same second.exr alone.exr
rm -rf c
for s in 0.02 0.05 0.1; do
  nephos render scene.yaml -q --cache c -o killed.exr >/dev/null &
  sleep $s
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
done
quietly --cache c -o after.exr
same after.exr alone.exr

echo 'bounded'
nephos render scene.yaml --progress none --cache small --cache-size 0.00001 -o small.exr 2>&1 | grep kept | sed -E 's/-[0-9a-f]{32}//; s/takes [0-9.e-]+/takes N/' | sort -u
ls small/nephos-cache
same small.exr alone.exr

echo 'no folder'
nephos render scene.yaml -q --cache scene.yaml -o no.exr || echo $?
nephos render scene.yaml -q --cache scene.yaml/such -o no.exr || echo $?
