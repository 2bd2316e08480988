# SPDX-License-Identifier: Apache-2.0
# A sunrise and a camera move of 100 frames: prints the tables of docs/results/animation.md.
#
#   sh sequence.sh NEPHOS
#
# Columns of the sunrise: render.light_reuse; solutions of multiple scattering; CPU seconds of the program; root mean
# square and greatest error a pixel of 15 frames against the same frames with light_reuse 0, of the same seed.
# CPU seconds of the move: 1 frame, 100 frames, and 100 processes of a frame each.
set -eu
export LC_ALL=C
nephos=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

write_scene() { # KEYS
  cat <<END
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], fov: 50 deg, resolution: [96, 54]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds:
  - {name: field, bake: {preset: cumulus_humilis, seed: 3, extent: 2 km, voxel: 40 m, coverage: 0.6}}
animate: {$1}
render: {samples: 1}
output: {image: "out.####.exr"}
END
}

render() { # OPTIONS
  "$nephos" render -q -t 1 "$@" >/dev/null
}

measure_cpu() { # OPTIONS
  ( render "$@"; times ) | awk 'END { split($1, t, "m"); printf "%.1f", 60 * t[1] + t[2] }'
}

print_errors() { # LIGHT_REUSE
  for frame in $(seq -w 3 7 101); do
    "$nephos" compare "q.0$frame.exr" "r.0$frame.exr" --json
  done | tr -d '{},' | tr ' ' '\n' | awk '
    name == "\"pixel_error\":" { sum += $1 * $1; count++; if ($1 > most) most = $1 }
    { name = $1 }
    END { printf "%.2f %% | %.2f %%", 100 * sqrt(sum / count), 100 * most }'
}

print_sunrise() {
  write_scene 'sun.elevation: [[1, -4 deg], [101, 12 deg]], sun.azimuth: [[1, 55 deg], [101, 72 deg]]' >sunrise.yaml
  render sunrise.yaml --frames 3-101x7 --samples 16 --set render.light_reuse=0 -o r.####.exr
  for reuse in 0 0.5 1 2 4; do
    render sunrise.yaml --frames 3-101x7 --samples 16 --set render.light_reuse=$reuse -o q.####.exr
    solved=$("$nephos" render sunrise.yaml -v -t 1 --frames 1-101 --resolution 8x5 --set render.light_reuse=$reuse 2>&1 |
      grep -c 'multiple scattering: [0-9].* cells')
    echo "| $reuse deg | $solved | $(measure_cpu sunrise.yaml --frames 1-101 --set render.light_reuse=$reuse) | $(print_errors) |"
  done
}

print_move() {
  write_scene 'camera.position: {interpolation: smooth, keys: [[1, [0, -3 km, 900 m]], [50, [600 m, -2.6 km, 1.1 km]],
    [100, [1.5 km, -2 km, 1000 m]]]}' >move.yaml
  one=$(measure_cpu move.yaml --frames 1)
  all=$(measure_cpu move.yaml --frames 1-100)
  each=0
  for frame in 1 25 50 75 100; do
    each=$(echo "$each $(measure_cpu move.yaml --frames $frame)" | awk '{ print $1 + 20 * $2 }')
  done
  echo "| $one | $all | $each |"
}

print_sunrise
print_move
