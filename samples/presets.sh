#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# presets.sh [NAME…]: every preset, or those named, under the sky of presets.yaml: from the front, from the side and from
# above, into samples/out/presets. Where ImageMagick's montage is installed they become one sheet, presets.png there.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
out=samples/out/presets
mkdir -p "$out"

# show PRESET VIEW POSITION LOOK_AT FOV
show() {
  "$program" render samples/presets.yaml --resolution 320x180 --samples 2 \
    --set "clouds[0].bake.preset=$1" --set "clouds[0].vdb=out/presets/$1.vdb" \
    --set "camera.position=[$3]" --set "camera.look_at=[$4]" --set "camera.fov=$5 deg" \
    --set "output.image=out/presets/$1.$2.exr" --set "output.preview=out/presets/$1.$2.png"
}

# Kilometres, for each preset: how far off, how high and what height in view of the two side views (the second looks
# east), and how high the view from above.
cameras='
cumulus_humilis      5.5 0.5 1.3  5.5 0.9 1.1   9
cumulus_mediocris    7   0.8 1.7  7   1.4 1.6   10
cumulus_congestus    10  0.8 2.5  10  2   2.4   13
stratocumulus        3.5 0.1 0.95 6.5 1.8 1.1   9
stratus              6   0.05 0.5 11  1.5 0.5   16
nimbostratus         16  0.3 1.5  18  5   2     24
altocumulus_floccus  3.5 1.5 3.7  5   2.8 3.7   10
altostratus          9   0.2 3.6  19  6.5 4     26
cumulonimbus         36  1   5.5  36  1   5.5   42
cirrus               6   0.1 8.4  9   0.1 8.4   22
fog                  3   0.5 0.1  5   1.2 0.1   9
valley_stratus       9   1.5 0.6  11  2.5 0.6   18
altocumulus_lenticularis 14 0.3 4.6 16 2 5      28
contrail             8   0.1 9.6  12  3   9.9   26
'
echo "$cameras" | while read -r preset front front_z front_at side side_z side_at above; do
  case " ${*:-$preset} " in *" $preset "*) ;; *) continue ;; esac
  [ -n "$preset" ] || continue
  show "$preset" front "0 km, -$front km, $front_z km" "0 km, 0 km, $front_at km" 60
  show "$preset" side "-$side km, 0 km, $side_z km" "0 km, 0 km, $side_at km" 60
  show "$preset" top "0 km, -2 km, $above km" "0 km, 0 km, 0 km" 50
done

command -v montage >/dev/null || exit 0
set --
for preset in $(echo "$cameras" | awk '{print $1}'); do
  label=$(echo "$preset" | tr _ ' ')
  for view in front side top; do
    [ -e "$out/$preset.$view.png" ] || continue
    set -- "$@" -label "$label, $view" "$out/$preset.$view.png"
  done
done
montage -pointsize 11 "$@" -tile 6x -geometry 256x144+2+2 -strip -depth 8 "$out/presets.png"
ls -l "$out/presets.png"
