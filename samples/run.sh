#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and renders every scene of this folder into samples/out. A scene NAME.yaml names
# out/NAME.exr as its picture; clouds that go to files are baked to them on the way. What is newer than its scene and
# the program stays.
# Scenes hero_NAME are rendered small: `nephos render` makes them at 1920×1080.
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing_packages

[ -f build/release/build.ninja ] || cmake --preset release
cmake --build --preset release
program=build/release/bin/nephos
mkdir -p samples/out

# is_current FILE SCENE: FILE is newer than the scene, the program and the library.
is_current() {
  [ -n "$(find "$1" -newer "$2" -newer "$program" -newer build/release/lib/libnephos.so 2>/dev/null)" ]
}

for scene in samples/*.yaml; do
  base=samples/out/$(basename "$scene" .yaml)
  if is_current "$base.exr" "$scene"; then
    echo "$scene: up to date"
    continue
  fi
  echo "$scene:"
  case $scene in
    */hero_* | */horizon.yaml) "$program" render "$scene" --resolution 480x270 --samples 2 ;;
    *) "$program" render "$scene" ;;
  esac
done

echo "samples/compose.c:"
build/release/bin/sample_compose samples/out

echo "samples/radiance_by_elevation.py:"
PYTHONPATH=build/release/python NEPHOS_LIBRARY=build/release/lib/libnephos.so \
  /usr/bin/python3 samples/radiance_by_elevation.py -o samples/out/radiance_by_elevation.png

echo "The pictures (.exr, and a .png of each to look at) lie in $(pwd)/samples/out:"
ls -l samples/out/*.exr samples/out/*.png
