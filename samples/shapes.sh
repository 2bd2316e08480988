#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# shapes.sh: clouds in shapes that an artist gives, into samples/out/shapes: of spheres, of a curve, of a mesh and of a
# height map, and fields by a painted map of coverage and of type. Mesh and pictures are made here, the latter by
# ImageMagick, whose montage makes one sheet of all, shapes.png there. Pictures that exist stay.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
out=samples/out/shapes
mkdir -p "$out"

# A screw of a turn and three quarters that rises and thins out: points with radii.
screw() {
  awk 'BEGIN {
    for (n = 0; n <= 21; n++) {
      turn = n / 12 * 6.2831853; along = n / 21
      printf "%s[%.0f m, %.0f m, %.0f m, %.0f m]", n ? ", " : "", (1500 - 700 * along) * cos(turn),
        (1500 - 700 * along) * sin(turn), 220 + 2000 * along, 210 - 120 * along
    }
  }'
}

# A ring that stands upright, 1 across from middle to middle of its tube, which is 0.34 thick: a closed mesh.
ring() {
  awk -v sides=96 -v corners=32 'BEGIN {
    for (i = 0; i < sides; i++)
      for (j = 0; j < corners; j++) {
        a = i / sides * 6.2831853; b = j / corners * 6.2831853
        r = 0.5 + 0.17 * cos(b)
        printf "v %.6f %.6f %.6f\n", r * cos(a), 0.17 * sin(b), r * sin(a)
      }
    for (i = 0; i < sides; i++)
      for (j = 0; j < corners; j++) {
        k = (i + 1) % sides; l = (j + 1) % corners
        printf "f %d %d %d %d\n", i * corners + j + 1, i * corners + l + 1, k * corners + l + 1, k * corners + j + 1
      }
  }'
}

# show NAME POSITION LOOK_AT ARGUMENT…
show() {
  name=$1 position=$2 target=$3
  shift 3
  [ -e "$out/$name.png" ] || "$program" render samples/shapes.yaml --quiet --set "camera.position=[$position]" \
    --set "camera.look_at=[$target]" "$@" -o "$out/$name.png"
}

# paint NAME ARGUMENT…: a picture of 256 × 256, white on black.
paint() {
  name=$1
  shift
  [ -e "$out/$name.map.png" ] || convert -size 256x256 xc:black -fill white "$@" -depth 16 -type grayscale \
    "PNG48:$out/$name.map.png"
}

south='0 km, -6.4 km, 900 m' middle='0 km, 0 km, 1850 m'
show spheres "$south" "$middle" --set "clouds[0].bake.shape={spheres: [[-900 m, 0 m, 380 m, 520 m],
  [-200 m, 300 m, 620 m, 640 m], [350 m, -100 m, 1000 m, 560 m], [480 m, 0 m, 1450 m, 380 m], [1100 m, 0 m, 300 m, 420 m]]}"
show curve '0 km, -7 km, 3400 m' '0 km, 0 km, 1900 m' --set "clouds[0].bake.thickness=2700 m" \
  --set "clouds[0].bake.billow=260 m" --set "clouds[0].bake.shape={curves: [[$(screw)]]}"
[ -e "$out/ring.obj" ] || ring >"$out/ring.obj"
show mesh "$south" "$middle" --set "clouds[0].bake.shape={mesh: {file: out/shapes/ring.obj, up: z, rotation: 25 deg}}"

if command -v convert >/dev/null; then
  paint heights -draw 'circle 128,128 128,28' -fill black -draw 'circle 158,108 158,28' -blur 0x9 -level '30%,100%'
  paint coverage -stroke white -strokewidth 34 -fill none \
    -draw 'path "M 200,60 C 40,0 10,130 128,128 C 246,126 216,256 56,196"' -blur 0x5
  paint type -fill none -sparse-color barycentric '0,128 black 255,128 white'
  show heights '0 km, -5.6 km, 5.4 km' '0 km, -0.3 km, 1200 m' \
    --set "clouds[0].bake.shape={height_map: {image: out/shapes/heights.map.png, channel: R, size: 4 km, height: 1200 m}}"
  field="clouds[0].bake.extent=14 km"
  show coverage '0 km, -9 km, 12 km' '0 km, -0.9 km, 900 m' --set "$field" --set 'clouds[0].bake.voxel=30 m' \
    --set 'clouds[0].bake.cell=800 m' --set 'clouds[0].bake.thickness=800 m' \
    --set 'camera.fov=46 deg' \
    --set 'clouds[0].bake.map={image: out/shapes/coverage.map.png, coverage: R, size: 9 km}'
  show type '0 km, -13 km, 900 m' '0 km, 0 km, 1700 m' --set "$field" --set 'clouds[0].bake.voxel=30 m' \
    --set 'clouds[0].bake.coverage=0.4' --set 'clouds[0].bake.cell=2 km' --set 'camera.fov=64 deg' \
    --set 'clouds[0].bake.type=1' --set 'clouds[0].bake.map={image: out/shapes/type.map.png, type: R}'
fi

command -v montage >/dev/null || exit 0
set --
for name in spheres curve mesh heights coverage type; do
  [ -e "$out/$name.png" ] && set -- "$@" -label "$name" "$out/$name.png"
done
montage -pointsize 12 "$@" -tile 3x -geometry 400x225+2+2 -strip -depth 8 "$out/shapes.png"
ls -l "$out/shapes.png"
