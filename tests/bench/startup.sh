#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# CPU time and memory of nephos on three scenes of one thing each, above the least programs that do the same: medians of
# five times ten runs of each in turn, one thread.
#   sh tests/bench/startup.sh build/release CLOUD.vdb TILE.hgt     (CLOUD.vdb: any; TILE.hgt: of 1201² samples)
set -eu
build=$1 vdb=$(realpath "$2") hgt=$(realpath "$3")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

common='camera: {position: [0, -3 km, 9000 m], look_at: [0, 0, 0], resolution: [48, 27]}
render: {samples: 1}'
printf '%s\nsun: {elevation: 37 deg}\noutput: {image: a.exr, color_space: bands}\n' "$common" >"$folder/sky.yaml"
printf '%s\natmosphere: none\nclouds: [{vdb: %s, extinction: 1}]\noutput: {image: a.exr, beauty: false, aovs: [depth]}\n' \
  "$common" "$vdb" >"$folder/cloud.yaml"
printf '%s\nterrain: {heightfield: %s}\noutput: {image: a.exr, beauty: false, aovs: [distance]}\n' \
  "$common" "$hgt" >"$folder/terrain.yaml"

# measure NAME COMMAND…: a line of CPU milliseconds and kilobytes of one run, the mean of ten, into a file.
measure() {
  name=$1
  shift
  /usr/bin/time -q -f '%U %S %M' -o "$folder/ten" sh -c 'for n in 0 1 2 3 4 5 6 7 8 9; do "$@" || exit; done' - "$@" \
    >"$folder/log" 2>&1 || { cat "$folder/log" >&2; exit 1; }
  awk '{ print 100 * ($1 + $2), $3 }' "$folder/ten" >>"$folder/$name"
}

median() { # FILE FIELD
  cut -d' ' -f"$2" "$folder/$1" | sort -g | sed -n 3p
}

for scene in sky cloud terrain; do
  case $scene in
    sky) input= ;;
    cloud) input=$vdb ;;
    terrain) input=$hgt ;;
  esac
  for run in 1 2 3 4 5; do
    measure "$scene.ours" "$build/bin/nephos" render "$folder/$scene.yaml" -q -t 1
    measure "$scene.least" "$build/bin/startup_$scene" ${input:+"$input"} "$folder/b.exr"
  done
  printf '%-8s %5s ms %7s KB, least %5s ms %7s KB\n' $scene \
    "$(median $scene.ours 1)" "$(median $scene.ours 2)" \
    "$(median $scene.least 1)" "$(median $scene.least 2)"
done
