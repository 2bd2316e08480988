#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# abi.sh [--update] LIBRARY COMPILER: compares the binary interface of the library with that of version 0.1.0 in
# nephos-0.1.abi: every exported function with its types, as the public headers declare them. A change that breaks
# linked programs needs another minor version; --update records the interface anew.
set -eu
command -v abidiff >/dev/null || {
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "abigail-tools is required here"; exit 1; }
  exit 77
}
update=
if [ "$1" = --update ]; then
  update=yes
  shift
fi
source=$(cd "$(dirname "$0")" && pwd)
include=$(cd "$source/../../include" && pwd)
library=$1 compiler=$2 recorded=$source/nephos-0.1.abi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Libraries of releases have no debugging data: a pointer to each function brings its type.
describe() { # describe INCLUDE FILE
  {
    for header in "$1"/nephos/*.h; do echo "#include <nephos/$(basename "$header")>"; done
    nm -D --defined-only "$library" | awk '$2 == "T" {print "__typeof__(" $3 ") *const abi_" $3 " = " $3 ";"}'
  } >"$folder/abi.c"
  (cd "$folder" && "$compiler" -std=c11 -g -I "$1" -shared -fPIC abi.c -o libabi.so)
  abidw --no-show-locs --no-corpus-path --no-comp-dir-path "$folder/libabi.so" >"$2"
}

describe "$include" "$folder/now.abi"
if [ -n "$update" ]; then
  cp "$folder/now.abi" "$recorded"
  exit 0
fi
abidiff "$recorded" "$folder/now.abi" || {
  echo "the binary interface is not that of 0.1.0: where it is meant to be another, abi.sh --update records it"
  exit 1
}

# The comparison sees a member that moves.
mkdir "$folder/include"
cp -r "$include/nephos" "$folder/include/nephos"
sed -i 's/^  double planet_radius_m, /  float planet_radius_m, /; s/^  double planet_radius_m;/  float planet_radius_m;/' \
  "$folder/include/nephos/atmosphere.h"
describe "$folder/include" "$folder/changed.abi"
if abidiff "$recorded" "$folder/changed.abi" >/dev/null; then
  echo "a changed member is not seen"
  exit 1
fi
