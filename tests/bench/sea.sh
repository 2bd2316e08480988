# SPDX-License-Identifier: Apache-2.0
# The open sea from 300 m, march against path: prints the table of docs/results/terrain.md.
#
#   sh sea.sh NEPHOS
#
# NEPHOS   the program
set -eu
export LC_ALL=C
nephos=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/sea.yaml" <<'YAML'
version: 1
camera: {position: [0 m, 0 m, 300 m], look_at: [0 m, 1 km, 150 m], fov: 40 deg, resolution: [24, 16]}
sun: {azimuth: 60 deg}
water: {wind: 5 m/s}
render: {samples: 1024}
output: {pixel_type: float, color_space: bands}
YAML

# mean INTEGRATOR ELEVATION: the means of the picture's R, G and B.
mean() {
  "$nephos" render "$folder/sea.yaml" --integrator "$1" --set sun.elevation="$2deg" -o "$folder/sea.exr" -q >/dev/null
  "$nephos" info "$folder/sea.exr" | sed -n 's/^ *nephos:mean  *//p'
}

echo "| sun's elevation | 680 nm | 550 nm | 440 nm |"
echo "| --- | --- | --- | --- |"
for elevation in 60 30 15 8 3; do
  echo "$elevation $(mean march $elevation) $(mean path $elevation)" |
    awk '{ printf "| %s° | %+.1f %% | %+.1f %% | %+.1f %% |\n", $1, 100*($2/$5-1), 100*($3/$6-1), 100*($4/$7-1) }'
done
