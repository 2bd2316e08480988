#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# blender_light.sh [NEPHOS]: lights a sphere in Cycles with the sky that nephos writes, sun included, and compares the
# irradiance on its top with nephos's own: at most 2 % apart in each channel. Wants Blender; takes half a minute.
set -eu
nephos=${1:-nephos}
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/scene.yaml" <<'END'
version: 1
camera: {position: [0, 0, 100 m], look_at: [0, 1 km, 100 m]}
sun: {elevation: 40 deg, azimuth: 90 deg}
END
"$nephos" sky "$work/scene.yaml" -q -o "$work/sky.exr" --center 90 --resolution 2048x1024 >"$work/irradiance"
scale=$("$nephos" info "$work/sky.exr" | awk '$1 == "nephos:scale" { print $2 }')
blender -b -P "$here/blender_light.py" -- "$work/sky.exr" >"$work/blender.log" 2>&1 || {
  cat "$work/blender.log"
  exit 1
}
grep '^cycles irradiance' "$work/blender.log" | cat - "$work/irradiance" | awk -v scale="$scale" '
  /^cycles/ { for (c = 1; c <= 3; c++) cycles[c] = $(c + 2) / scale }
  /^(sun|sky) irradiance/ { for (c = 1; c <= 3; c++) own[c] += $(c + 2) }
  END {
    for (c = 1; c <= 3; c++) {
      off = cycles[c] / own[c] - 1
      printf "%s: Cycles %.5f, nephos %.5f W/m2/nm, %+.2f %%\n", substr("RGB", c, 1), cycles[c], own[c], 100 * off
      if (!(off < 0.02 && off > -0.02)) failed = 1
    }
    exit failed
  }'
