# SPDX-License-Identifier: Apache-2.0
# Predicted time, memory and error of pictures with a target error, against what came: prints the table of
# docs/results/targets.md.
#
#   sh targets.sh NEPHOS CLOUD.vdb FOLDER [SCENES [SIZES [TARGETS]]]
#
# NEPHOS   the program
# CLOUD    wdas_cloud_sixteenth.vdb
# FOLDER   for scenes, calibration and pictures
# SCENES   of "cumulus_field sunset disney hills"; default all
# SIZES    default "240x135 480x270"
# TARGETS  default "0.1 0.03"
#
# Seconds are CPU time of one thread: other processes may compute meanwhile. Where paths are chosen a strip of the picture
# is rendered, a sixteenth of its columns, and predicted as such: the whole would take a quarter of an hour and more.
set -eu
export LC_ALL=C
nephos=$1 cloud=$2 folder=$3
scenes=${4:-cumulus_field sunset disney hills} sizes=${5:-240x135 480x270} targets=${6:-0.1 0.03}
samples_folder=$(cd "$(dirname "$0")/../../samples" && pwd)
mkdir -p "$folder"
cd "$folder"

for name in cumulus_field sunset; do
  sed '/^ *vdb: /d; /^render/d; /^output/d' "$samples_folder/$name.yaml" >"$name.yaml"
done
cat >disney.yaml <<END
version: 1
camera: {position: [0, -700 m, 1600 m], look_at: [0, 0, 1640 m], fov: 40 deg, resolution: [960, 540]}
sun: {elevation: 25 deg, azimuth: 10 deg}
clouds:
  - {vdb: $cloud, up: y, optical_depth: 40, position: [0, 0, 1500 m], phase: {hg: 0.85}, albedo: 0.999995}
END
cat >hills.yaml <<END
version: 1
camera: {position: [0, -8 km, 900 m], look_at: [0, 0, 700 m], fov: 50 deg, resolution: [960, 540]}
sun: {elevation: 20 deg, azimuth: 120 deg}
terrain: {ridges: {seed: 3, relief: 900 m}, width: 40 km, albedo: [0.1, 0.12, 0.06]}
END
[ -f machine.json ] || "$nephos" report --calibrate --threads 1 -q -o machine.json >/dev/null

# FIELD of the JSON line on standard input; "-" where it is missing.
get() { tr -d '{}"' | tr ',' '\n' | awk -v field="$1" -F': ' '{gsub(/^ +/, "", $1)} $1 == field {print $2; found = 1} END {if (!found) print "-"}'; }

# Settings that were chosen, in few words.
describe() {
  awk '/^settings/ {for (i = 2; i <= NF; i++) {if ($i == "quality") quality = $(i + 1); if ($(i + 1) == "samples,") integrator = $(i - 1)}
       sub(",", "", quality); sub(",", "", integrator); print quality " " integrator}'
}

# Predictions are by the plan (--explain); a picture of the same settings that is there is not rendered again.
measure() { # SCENE SIZE TARGET
  name=$1.$2.$3 width=${2%x*} height=${2#*x} strip=
  printf '| %s | %s | %s %% |' "$1" "$2" "$(awk -v x="$3" 'BEGIN {print 100 * x}')"
  set -- "$1.yaml" --resolution "$2" --target-error "$3" --threads 1 --machine machine.json -q
  "$nephos" render "$@" --explain >"$name.plan"
  choice=$(describe <"$name.plan")
  case $choice in *path) strip=$((width * 3 / 8)),0,$((width * 7 / 16)),$height ;; esac
  grep ^settings "$name.plan" | sed 's/[0-9.e+]* samples, //' >"$name.wanted"
  "$nephos" render "$@" ${strip:+--crop $strip} --explain --json | tr -d '\n' >"$name.predicted"
  if ! cmp -s "$name.wanted" "$name.settings"; then
    "$nephos" render "$@" ${strip:+--crop $strip} --json -o part.exr >"$name.json"
    mv "$name.wanted" "$name.settings"
  fi
  sed 's/.*"prediction": {\([^}]*\)}.*/\1/' "$name.predicted" >"$name.prediction"
  printf ' %s%s |' "$choice" "${strip:+, strip}"
  awk -v ps="$(get seconds <"$name.prediction")" -v qs="$(get pilot_seconds <"$name.json")" \
    -v s="$(get cpu_seconds <"$name.json")" -v pb="$(get bytes <"$name.prediction")" \
    -v b="$(get memory_bytes <"$name.json")" -v pe="$(get error <"$name.prediction")" \
    -v qe="$(get pilot_error <"$name.json")" -v e="$(get error <"$name.json")" -v n="$(get noise <"$name.json")" \
    -v bias="$(get bias <"$name.json")" '
    BEGIN {
      printf " %.3g | %.3g | %.3g | %.2f | %.0f | %.0f | %.2f | %.2g | %.2g | %.2g (%.2g, %.2g) | %.2f |\n", ps, qs, s, s / ps,
             pb / 1e6, b / 1e6, b / pb, 100 * pe, 100 * qe, 100 * e, 100 * n, 100 * bias, e / pe
    }'
}

echo '| scene | size | target | choice | predicted, CPU s | by pilots | measured | ratio | predicted, MB | measured | ratio | predicted error, % | by pilots | stated (noise, bias) | ratio |'
echo '| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |'
for scene in $scenes; do
  for size in $sizes; do
    for target in $targets; do measure "$scene" "$size" "$target"; done
  done
done
