# SPDX-License-Identifier: Apache-2.0
# Changes from frame to frame of a growing cloud: prints a row of docs/results/nature.md.
#
#   sh popping.sh NEPHOS [PRESET [FRAMES [STEP]]]
#
# Renders FRAMES pictures of a preset's field, STEP of cloud time apart, without wind, and prints the largest difference
# of neighbours over the median (rmse by `nephos compare`). The seed of the samples is the same in all.
set -eu
export LC_ALL=C
nephos=$(realpath "$1")
preset=${2:-cumulus_congestus}
count=${3:-60}
step=${4:-10 s}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

cat >scene.yaml <<END
version: 1
camera: {position: [0, -9 km, 1 km], look_at: [0, 0, 2 km], fov: 50 deg, resolution: [240, 135]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds:
  - bake: {preset: $preset, extent: 8 km, voxel: 50 m, seed: 3, wind: [0 m/s, 0 m/s], lifetime: 30 min, frame_time: $step}
render: {integrator: march, samples: 4}
output: {image: "out.####.exr"}
END
"$nephos" render -q scene.yaml --frames "1-$count"
for i in $(seq 2 "$count"); do
  "$nephos" compare --json "$(printf 'out.%04d.exr' "$i")" "$(printf 'out.%04d.exr' "$((i - 1))")" |
    sed 's/.*"rmse": \([-+0-9.e]*\).*/\1/'
done | sort -g | awk -v preset="$preset" -v step="$step" '
  { change[NR] = $1 }
  END { median = change[int((NR + 1) / 2)]
        printf "| %s | %d | %s | %.3g | %.2f |\n", preset, NR + 1, step, median, change[NR] / median }'
