#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# presets.sh [NAME…]: every preset, or those named, under the sky of presets.yaml: from the ground at mid-distance, from
# close, and from above, each at 960×540, into samples/out/presets. SCALE (default 1) divides both sides of a picture,
# SAMPLES (4) is per pixel. Pictures that exist stay, so that an interrupted run goes on: delete those to be made again.
# Where ImageMagick's montage is installed they become one sheet, presets.png there.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
scale=${SCALE:-1}
samples=${SAMPLES:-4}
out=samples/out/presets/$scale
mkdir -p "$out"

# show PRESET VIEW POSITION LOOK_AT FOV
show() {
  [ -e "$out/$1.$2.png" ] && return 0
  "$program" render samples/presets.yaml --resolution "$((960 / scale))x$((540 / scale))" --samples "$samples" \
    --set "clouds[0].bake.preset=$1" --set "clouds[0].vdb=out/presets/$1.vdb" \
    --set "camera.position=[$3]" --set "camera.look_at=[$4]" --set "camera.fov=$5 deg" \
    --set "output.image=out/presets/$scale/$1.$2.exr" --set "output.preview=out/presets/$scale/$1.$2.png"
}

# For each preset: distance (km), height and height in view of the first view, from the south; the same of the close
# one, from the west; and the height of the view from above.
cameras='
cumulus_humilis      5.5 0.05 1.3  2.2 0.7 1.2   9
cumulus_mediocris    7   0.05 1.7  4.8 1.1 1.8   10
cumulus_congestus    10  0.05 2.7  5   1.2 2.6   13
stratocumulus        3.5 0.05 1.0  4.6 1.7 1.1   9
stratus              6   0.05 0.5  11  1.1 0.5   16
nimbostratus         15  0.3  1.5  18  5   2     24
altocumulus_floccus  4   0.05 3.6  2.2 2.9 3.8   10
altostratus          9   0.05 3.6  19  6.5 4     26
cumulonimbus         36  0.05 5.5  21  2   8     42
cirrus               7   0.05 8.6  8   6   9.2   22
fog                  3   0.5  0.1  5   1.2 0.1   9
valley_stratus       9   1.5  0.6  11  2.5 0.6   18
altocumulus_lenticularis 14 0.05 4.6 9 3   4.9   28
contrail             9   0.05 9.8  5   8.6 10.1  26
'
echo "$cameras" | while read -r preset far far_z far_at close close_z close_at above; do
  case " ${*:-$preset} " in *" $preset "*) ;; *) continue ;; esac
  [ -n "$preset" ] || continue
  show "$preset" ground "0 km, -$far km, $far_z km" "0 km, 0 km, $far_at km" 60
  show "$preset" close "-$close km, 0 km, $close_z km" "0 km, 0 km, $close_at km" 60
  show "$preset" above "0 km, -2 km, $above km" "0 km, 0 km, 0 km" 50
done

command -v montage >/dev/null || exit 0
set --
for preset in $(echo "$cameras" | awk '{print $1}'); do
  label=$(echo "$preset" | tr _ ' ')
  for view in ground close above; do
    [ -e "$out/$preset.$view.png" ] || continue
    set -- "$@" -label "$label, $view" "$out/$preset.$view.png"
  done
done
montage -pointsize 11 "$@" -tile 6x -geometry 200x112+2+2 -strip -depth 8 "$out/presets.png"
ls -l "$out/presets.png"
