#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# sample_compose.sh SAMPLE PROGRAM: samples/compose.c writes two pictures, each as EXR and PNG, with light in them that
# differs.
set -eu
sample=$1 program=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$sample" "$folder" 2>"$folder/messages" || { cat "$folder/messages"; exit 1; }
grep -q 's left' "$folder/messages"
if grep -q 'nephos: ' "$folder/messages"; then cat "$folder/messages"; exit 1; fi
for frame in 1 2; do
  [ -s "$folder/compose.$frame.png" ]
  "$program" info "$folder/compose.$frame.exr" >"$folder/info.$frame"
  grep -q '240 x 135' "$folder/info.$frame"
done
if "$program" compare --exact "$folder/compose.1.exr" "$folder/compose.2.exr" >/dev/null 2>&1; then exit 1; fi
if "$sample" "$folder/missing" 2>"$folder/messages"; then exit 1; fi
grep -q '^nephos: error: .*missing' "$folder/messages"
