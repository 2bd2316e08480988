#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Settings of the multiple scattering in pixels: prints the table of docs/results/light-solve.md. Cumuli under a sun at
# 35°, 48x27 pixels, 16 samples, over optical depth, albedo and asymmetry: relative rms of the picture against that of
# light_residual 1e-6 and the same seed, and user seconds of one thread for all of the render.
#
#   sh light_degree.sh NEPHOS
#
# NEPHOS   the program
set -eu
export LC_ALL=C
program=$(cd "$(dirname "${1:-build/release/bin/nephos}")" && pwd)/$(basename "${1:-nephos}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat >scene.yaml <<'Y'
version: 1
camera: {position: [0 m, -4 km, 1500 m], look_at: [0, 0, 1700 m], fov: 40 deg, resolution: [48, 27]}
sun: {elevation: 35 deg, azimuth: 100 deg}
clouds: [{bake: {preset: cumulus_mediocris, extent: 3 km, base: 1 km, voxel: 25 m, coverage: 0.5, seed: 4}}]
render: {samples: 16}
Y
# render NAME SETTING…: the picture NAME.exr, user seconds in NAME.time.
render() {
  name=$1
  shift
  (set -- "$@"; "$program" render scene.yaml -q -t 1 -o "$name.exr" "$@" >/dev/null; times >"$name.time")
}
seconds() { awk 'NR == 2 { split($1, t, /[ms]/); printf "%.1f", 60 * t[1] + t[2] }' "$1.time"; }
rms() { "$program" compare "$1.exr" "$2.exr" | awk '/^relative MSE/ { printf "%.2g", 100 * sqrt($3) }'; }

echo '| depth | albedo | g | default, % | s | preview, % | s | draft, % | s | degree 3, % | residual 0.01, % |'
echo '| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |'
for depth in 10 30 100; do
  for albedo in 1 0.99; do
    for g in 0.85 0; do
      [ $depth != 100 ] || [ $g != 0 ] || continue # cells of less than a voxel: minutes
      set -- --set "clouds[0].optical_depth=$depth" --set "clouds[0].albedo=$albedo" --set "clouds[0].phase={hg: $g}"
      render exact "$@" --set render.light_residual=1e-6
      render default "$@"
      render preview "$@" --quality preview
      render draft "$@" --quality draft
      render three "$@" --set render.light_degree=3
      render loose "$@" --set render.light_residual=0.01
      printf '| %s | %s | %s ' "$depth" "$albedo" "$g"
      for q in default preview draft; do printf '| %s | %s ' "$(rms $q exact)" "$(seconds $q)"; done
      printf '| %s | %s |\n' "$(rms three exact)" "$(rms loose exact)"
    done
  done
done
