#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# sliders.sh [NAME…]: the cloud of sliders.yaml with each slider, or those named, at 0, ¼, ½, ¾ and 1, at 320×180, into
# samples/out/sliders; tests/test_cloud_sliders.c measures the same sliders. Pictures that exist stay, so that an
# interrupted run goes on: delete those to be made again. Where ImageMagick's montage is installed they become one
# sheet, sliders.png there.
set -eu
cd "$(dirname "$0")/.."
program=${NEPHOS:-build/release/bin/nephos}
out=samples/out/sliders
mkdir -p "$out"

# Each slider: its name, its key, and the value with % in the place of the number. Amounts are those of top, flank, base,
# on a given shape, whose volume no coverage makes up for.
sliders='
coverage coverage %
type type %
billowiness billowiness %
erosion erosion %
wispiness wispiness %
turbulence turbulence %
softness softness %
age age %
precipitation precipitation %
streets streets %
billow_top billow_amounts [%,0.5,0.5]
billow_flank billow_amounts [0.5,%,0.5]
billow_base billow_amounts [0.5,0.5,%]
wisp_top wisp_amounts [%,0.5,0.5]
wisp_flank wisp_amounts [0.5,%,0.5]
wisp_base wisp_amounts [0.5,0.5,%]
'
shape='{spheres: [[-600 m, 0 m, 300 m, 500 m], [100 m, 200 m, 600 m, 560 m], [700 m, -200 m, 350 m, 450 m]]}'

# show SLIDER KEY VALUE NUMBER
show() {
  [ -e "$out/$1.$4.png" ] && return 0
  at=$(echo "$3" | sed "s/%/$4/")
  case $1 in
  *_*)
    set -- "$1" "$2" "$3" "$4" --set "clouds[0].bake.shape=$shape" --set clouds[0].bake.wispiness=1 \
      --set clouds[0].bake.billowiness=1
    ;;
  streets)
    set -- "$1" "$2" "$3" "$4" --set "clouds[0].bake.extent=16 km" --set "clouds[0].bake.voxel=40 m" \
      --set "clouds[0].bake.wind=[0 m/s, 8 m/s]" --set "camera.position=[0 km, -5 km, 9 km]"
    ;;
  esac
  name=$1 key=$2 number=$4
  shift 4
  "$program" render samples/sliders.yaml --quiet --set "clouds[0].bake.$key=$at" "$@" -o "$out/$name.$number.png"
}

echo "$sliders" | while read -r name key value; do
  case " ${*:-$name} " in *" $name "*) ;; *) continue ;; esac
  [ -n "$name" ] || continue
  for number in 0 0.25 0.5 0.75 1; do show "$name" "$key" "$value" "$number"; done
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
