#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# sliders.sh [NAME…]: the cloud of sliders.yaml with each slider, or those named, at 0, ¼, ½, ¾ and 1, at 256×144, into
# samples/out/sliders; tests/test_cloud_sliders.c measures the same sliders. Pictures that exist stay, so that an
# interrupted run goes on: delete those to be made again. Where ImageMagick's montage is installed they become one
# sheet, sliders.png there.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
out=samples/out/sliders
numbers=${NUMBERS:-0 0.25 0.5 0.75 1}
mkdir -p "$out"

# Each slider: its name, its view, its key, and the value with % in the place of the number. Amounts are those of top,
# flank, base, on a given shape, whose volume no coverage makes up for.
sliders='
coverage wide coverage %
type side type %
billowiness side billowiness %
erosion side erosion %
wispiness below wispiness %
turbulence side turbulence %
softness side softness %
age side age %
precipitation under precipitation %
streets above streets %
billow_top side billow_amounts [%,0.5,0.5]
billow_flank flank billow_amounts [0.5,%,0.5]
billow_base below billow_amounts [0.5,0.5,%]
wisp_top wide wisp_amounts [%,0,0]
wisp_flank limb wisp_amounts [0,%,0]
wisp_base rim wisp_amounts [0,0,%]
'
shape='{spheres: [[-600 m, 0 m, 300 m, 500 m], [100 m, 200 m, 600 m, 560 m], [700 m, -200 m, 350 m, 450 m]]}'

# look_from VIEW: sets `position`, `target` and `fov`.
look_from() {
  fov='46 deg'
  case $1 in
  wide) position='0 km, -5.2 km, 300 m' target='0 km, 0 km, 1700 m' ;;
  side) position='0 km, -2.9 km, 1000 m' target='0 km, 0 km, 1500 m' ;;
  flank) position='-0.9 km, -2.6 km, 1100 m' target='-0.8 km, 0 km, 1400 m' fov='40 deg' ;;
  below) position='-0.4 km, -2.6 km, 500 m' target='-0.4 km, 0 km, 1050 m' fov='44 deg' ;;
  limb) position='-1.2 km, -2.6 km, 1100 m' target='-1.3 km, 0 km, 1320 m' fov='17 deg' ;;
  rim) position='-1.1 km, -2.6 km, 500 m' target='-1.15 km, 0 km, 1000 m' fov='21 deg' ;;
  under) position='1.6 km, 2.2 km, 60 m' target='-200 m, 0 km, 800 m' ;;
  above) position='0 km, -5 km, 9 km' target='0 km, 0 km, 1700 m' ;;
  esac
}

# show SLIDER VIEW KEY VALUE NUMBER
show() {
  [ -e "$out/$1.$5.png" ] && return 0
  at=$(echo "$4" | sed "s/%/$5/")
  look_from "$2"
  case $1 in
  billow_*)
    set -- "$1" "$3" "$5" --set "clouds[0].bake.shape=$shape" --set clouds[0].bake.wispiness=0 \
      --set clouds[0].bake.billowiness=1
    ;;
  wisp_*)
    set -- "$1" "$3" "$5" --set "clouds[0].bake.shape=$shape" --set clouds[0].bake.wispiness=1 \
      --set clouds[0].bake.billowiness=0.6
    ;;
  streets)
    set -- "$1" "$3" "$5" --set "clouds[0].bake.extent=16 km" --set "clouds[0].bake.voxel=40 m" \
      --set "clouds[0].bake.wind=[0 m/s, 8 m/s]"
    ;;
  precipitation) set -- "$1" "$3" "$5" --set 'sun.elevation=65 deg' ;;
  *) set -- "$1" "$3" "$5" ;;
  esac
  name=$1 key=$2 number=$3
  shift 3
  "$program" render samples/sliders.yaml --quiet --set "camera.position=[$position]" --set "camera.look_at=[$target]" \
    --set "camera.fov=$fov" --set "clouds[0].bake.$key=$at" "$@" -o "$out/$name.$number.exr" \
    -o "$out/$name.$number.png"
}

echo "$sliders" | while read -r name view key value; do
  case " ${*:-$name} " in *" $name "*) ;; *) continue ;; esac
  [ -n "$name" ] || continue
  for number in $numbers; do show "$name" "$view" "$key" "$value" "$number"; done
done

# Root mean square of the change of scene-linear values from 0 to 1, over the mean at 0.
for name in $(echo "$sliders" | awk '{print $1}'); do
  [ -e "$out/$name.0.exr" ] && [ -e "$out/$name.1.exr" ] || continue
  mean=$("$program" info "$out/$name.0.exr" | awk '/nephos:mean / {print ($2 + $3 + $4) / 3}')
  change=$("$program" compare "$out/$name.1.exr" "$out/$name.0.exr" | awk '$1 == "RMSE" {print $2}')
  awk -v name="$name" -v change="$change" -v mean="$mean" 'BEGIN {printf "%-14s %5.1f %%\n", name, 100 * change / mean}'
done

command -v montage >/dev/null || exit 0
set --
for name in $(echo "$sliders" | awk '{print $1}'); do
  for number in 0 0.25 0.5 0.75 1; do
    [ -e "$out/$name.$number.png" ] || continue
    set -- "$@" -label "$(echo "$name" | tr _ ' ') $number" "$out/$name.$number.png"
  done
done
montage -pointsize 11 "$@" -tile 5x -geometry 220x124+2+2 -strip -depth 8 "$out/sliders.png"
ls -l "$out/sliders.png"
