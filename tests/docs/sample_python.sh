#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# sample_python.sh SOURCE_DIR: samples/radiance_by_elevation.py makes its plot of a small scene; clouds are brighter
# under a high sun than under a low one.
set -eu
source=$1
python=${NEPHOS_TEST_PYTHON:-/usr/bin/python3}
"$python" -c 'import matplotlib, numpy' 2>/dev/null || {
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "python3-matplotlib is required here"; exit 1; }
  exit 77
}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export MPLCONFIGDIR="$folder"
cat >"$folder/scene.yaml" <<END
version: 1
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg}
clouds:
  - {name: field, bake: {preset: cumulus_humilis, seed: 7, extent: 3 km, voxel: 80 m}}
END
"$python" "$source/samples/radiance_by_elevation.py" "$folder/scene.yaml" -o "$folder/plot.png" --steps 3 \
  --resolution 48x27 >"$folder/out"
cat "$folder/out"
awk '/^elevation/ {cloud[++count] = $4 + 0} END {exit !(count == 3 && cloud[3] > 2 * cloud[1] && cloud[1] > 0)}' "$folder/out"
head -c 8 "$folder/plot.png" | od -c | grep -q 'P   N   G'
