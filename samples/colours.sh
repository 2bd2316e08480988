#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Radiances at 680, 550 and 440 nm, above, the colours of three bands, and those of 15 wavelengths, below: the sky at
# noon, clouds under a sun of 40 degrees, the sun two degrees up, and the clouds with the sun three degrees up. Into
# samples/out/colours; where ImageMagick's montage is installed they become one sheet, colours.png there.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
out=samples/out/colours
mkdir -p "$out"

sky='camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 10 km, 1700 m], fov: 60 deg}
'
clouds='camera: {position: [0 m, -4 km, 600 m], look_at: [0 m, 0 m, 1700 m], fov: 60 deg}
clouds: [{bake: {preset: cumulus_mediocris, seed: 7, extent: [5 km, 5 km], voxel: 60 m, coverage: 0.45}}]
terrain: {ridges: {samples: 257, relief: 500 m}, width: 20 km, albedo: [0.12, 0.16, 0.08]}
'

# show NAME SCENE ELEVATION AZIMUTH
show() {
  for row in bands-3 rec709-3 rec709-15; do
    printf 'version: 1\n%s' "$2" | "$program" render - --resolution 240x135 --samples 8 -o "$out/$1.$row.png" \
      --set "sun={elevation: $3 deg, azimuth: $4 deg}" \
      --set "output.color_space=${row%-*}" --set "render.wavelengths=${row#*-}"
  done
}

show noon "$sky" 60 180
show clouds "$clouds" 40 70
show sunset "$sky" 2 0
show evening "$clouds" 3 70

command -v montage >/dev/null || exit 0
set --
for row in bands-3 rec709-3 rec709-15; do
  for name in noon clouds sunset evening; do set -- "$@" "$out/$name.$row.png"; done
done
montage "$@" -tile 4x -geometry 240x135+2+2 -background black -strip -depth 8 "$out/colours.png"
ls -l "$out/colours.png"
