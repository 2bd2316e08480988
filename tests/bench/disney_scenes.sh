# SPDX-License-Identifier: Apache-2.0
# Scenes of the benchmarks on a cloud that is lit from all sides, and CPU seconds of what renders them. To be sourced, by a
# script that has set `nephos`, `cloud` and `folder`.

write_scene() { # SKY PHASE DEPTH ELEVATION AZIMUTH
  height=0
  lobe='{hg: 0.85}'
  [ "$1" = black ] || height=1500
  [ "$2" = hg ] || lobe='{droplets: {diameter: 20 um}}'
  cat <<END
version: 1
camera:
  position: [0, -700 m, $((height + 100)) m]
  look_at: [0, 0, $((height + 140)) m]
  fov: 40 deg
  resolution: [120, 68]
sun: {elevation: $4 deg, azimuth: $5 deg}
clouds: [{vdb: $cloud, up: y, optical_depth: $3, position: [0, 0, $height m], phase: $lobe}]
render: {atmosphere: tables, air_shadows: false}
output: {pixel_type: float, color_space: bands, film: {background: false}}
END
  [ "$1" != black ] || printf 'atmosphere: none\nenvironment: {planet: none}\n'
}

# CPU seconds of the children so far; `times` must not run in a subshell.
read_clock() {
  times >"$folder/times"
  awk 'END {for (i = 1; i <= 2; i++) {split($i, t, "[ms]"); sum += 60 * t[1] + t[2]}; printf "%.2f", sum}' "$folder/times"
}

render() { # CPU SCENE OUTPUT [OPTIONS]
  cpu=$1 scene=$2 output=$3
  shift 3
  read_clock >"$folder/before"
  "$nephos" render "$scene" --threads 1 -q "$@" -o "$folder/part.exr" >"$folder/said"
  read_clock >"$folder/after"
  paste "$folder/before" "$folder/after" | awk '{printf "%.2f\n", $2 - $1}' >"$cpu"
  mv "$folder/part.exr" "$output"
}
