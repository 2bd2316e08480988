#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# sample_program.sh PROGRAM SOURCE_DIR: what README.md shows of samples/render_scene.c stands there, and the program
# renders.
set -eu
program=$1 source=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

awk '/^```c$/ { inside = 1; next } /^```/ { inside = 0 } inside' "$source/README.md" >"$folder/shown.c"
[ -s "$folder/shown.c" ] || { echo "README.md shows no C"; exit 1; }
while IFS= read -r line; do
  grep -Fxq -- "$line" "$source/samples/render_scene.c" || { echo "not in samples/render_scene.c: $line"; exit 1; }
done <"$folder/shown.c"

cat >"$folder/scene.yaml" <<'SCENE'
camera: {resolution: [8, 6]}
atmosphere: none
environment: {radiance: 1}
SCENE
"$program" "$folder/scene.yaml" "$folder/picture.exr"
[ -s "$folder/picture.exr" ]
if "$program" "$folder/missing.yaml" "$folder/none.exr" 2>"$folder/messages"; then exit 1; fi
grep -q 'missing.yaml' "$folder/messages"
[ ! -e "$folder/none.exr" ]
