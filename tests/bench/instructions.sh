#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Instructions of each stage of fixed scenes, 48 × 27 pixels, one sample, one thread, x86-64-v3, by Callgrind: a stage
# that a scene lacks must not cost it, and one that it has must not get dearer unseen.
#   sh tests/bench/instructions.sh BENCH_STAGES            compares with instructions.csv, to 2 %; 1 where one differs
#   sh tests/bench/instructions.sh BENCH_STAGES --update   writes it anew; say in the commit why
set -eu
bench=$(realpath "$1") update=${2:-}
table=$(cd "$(dirname "$0")" && pwd)/instructions.csv
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

view='camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [48, 27]}'
sun='sun: {elevation: 30 deg, azimuth: 140 deg}'
heap='clouds: [{bake: {model: hero, seed: 3, extent: [600 m, 600 m], voxel: 20 m}}]'
hills='terrain: {ridges: {samples: 129, relief: 200 m}, width: 10 km}'
night='place: {latitude: 45 deg, longitude: 0 deg}
sun: {elevation: -30 deg, azimuth: 100 deg}
moon: {elevation: 40 deg, azimuth: 100 deg}
stars: {sidereal_time: 30 deg}
airglow: {}'

# scene NAME RENDER LINE…: a scene of these lines.
scene() {
  name=$1 render=$2
  shift 2
  { printf '%s\n' "$view" "$@"; printf 'render: {samples: 1%s}\n' "$render"; } >"$folder/$name.yaml"
  scenes="${scenes:-} $name"
}
scene sky '' "$sun"
scene sky_path ', integrator: path' "$sun"
scene sea '' "$sun" 'water: {}'
scene hills '' "$sun" "$hills"
scene night '' "$night"
scene cloud '' "$sun" "$heap"
scene cloud_volume ', sun_optical_depth: volume, air_shadows: true' "$sun" "$heap" "$hills"
scene cloud_octaves ', multiple_scattering: octaves' "$sun" "$heap"
scene cloud_path ', integrator: path' "$sun" "$heap"
scene cloud_guided ', integrator: path, path_guiding: adjoint' "$sun" "$heap"
scene cloud_night '' "$night" "$heap"
scene depth '' "$sun" "$heap" 'output: {beauty: false, aovs: [depth]}'

# A dump ends where a stage begins, and is triggered by its name: what it counts is the stage before.
count_stages() {
  valgrind --tool=callgrind --callgrind-out-file="$folder/count" "$bench" "$folder/$1.yaml" >"$folder/log" 2>&1 ||
    { cat "$folder/log" >&2; return 1; }
  set -- "$1" $(ls "$folder" | sed -n 's/^count\.\([0-9]*\)$/\1/p' | sort -n)
  name=$1 stage=start
  shift
  for part; do
    awk -v scene="$name" -v stage="$stage" '/^summary:|^totals:/ { n = $2 } END { printf "%s,%s,%.0f\n", scene, stage, n }' \
      "$folder/count.$part"
    stage=$(sed -n 's/^desc: Trigger: Client Request: //p' "$folder/count.$part")
  done
  rm -f "$folder"/count*
}

for name in $scenes; do count_stages "$name"; done |
  awk -F, '{ if (!(($1, $2) in sum)) order[++count] = $1 "," $2; sum[$1, $2] += $3 }
           END { for (i = 1; i <= count; i++) { split(order[i], key, ","); printf "%s,%.0f\n", order[i], sum[key[1], key[2]] } }' \
    >"$folder/now"

if [ "$update" = --update ]; then
  { echo 'scene,stage,instructions'; cat "$folder/now"; } >"$table"
  exit
fi
awk -F, 'FNR == 1 && NR == 1 { next }
         NR == FNR { was[$1, $2] = $3; all[$1 "," $2]; next }
         { seen[$1 "," $2]
           if (!(($1, $2) in was)) { print $1 ", " $2 ": new, " $3; bad = 1; next }
           change = was[$1, $2] ? $3 / was[$1, $2] - 1 : 0
           # A hundred thousand instructions are lost in what the system does.
           if ((change > 0.02 || change < -0.02) && ($3 > was[$1, $2] + 1e5 || $3 < was[$1, $2] - 1e5)) {
             printf "%s, %s: %d, %+.1f %% of %d\n", $1, $2, $3, 100 * change, was[$1, $2]; bad = 1 } }
         END { for (key in all) if (!(key in seen)) { print key ": gone"; bad = 1 } exit bad }' "$table" "$folder/now"
