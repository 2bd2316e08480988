#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and renders every scene of this folder into samples/out. A scene NAME.yaml names
# out/NAME.exr as its picture; clouds that go to files are baked to them on the way. What is newer than its scene and
# the program stays.
# Pictures are smaller and coarser than those that the scenes describe, to save time:
# `nephos render samples/NAME.yaml` makes one at its own size and quality.
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

# render SCENE OPTION...: the scene with the tolerances of previews, which keep detail finer than voxels.
render() {
  "$program" render "$@" --set render.tolerance=0.04 --set render.light_depth=0.6 --set render.light_degree=7 \
    --set render.light_residual=0.003
}

# render_hero SCENE OPTION...: the scene at a quarter of its size, with coarse voxels and cells of multiple scattering.
render_hero() {
  "$program" render "$@" --quality preview --resolution 480x270 --samples 2
}

for scene in samples/*.yaml; do
  base=samples/out/$(basename "$scene" .yaml)
  if is_current "$base.exr" "$scene"; then
    echo "$scene: up to date"
    continue
  fi
  echo "$scene:"
  case $scene in
    */hero_congestus.yaml)
      render_hero "$scene" --set "clouds[0].bake.voxel=20 m" --set "render.light_memory=0.25 GB" ;;
    */hero_noon.yaml)
      render_hero "$scene" --set "clouds[0].bake.voxel=24 m" --set "render.light_memory=0.25 GB" ;;
    */hero_thunderhead.yaml)
      render_hero "$scene" --set "clouds[0].bake.voxel=90 m" --set "clouds[1].bake.voxel=60 m" \
        --set "render.light_memory=0.35 GB" ;;
    */coast.yaml) render "$scene" --resolution 640x360 --samples 6 ;; # glitter
    */horizon.yaml) "$program" render "$scene" --quality preview --resolution 480x270 --samples 2 ;;
    */shapes.yaml | */sliders.yaml) render "$scene" --samples 2 ;;
    *) render "$scene" --resolution 640x360 --samples 2 ;;
  esac
done

echo "samples/compose.c:"
build/release/bin/sample_compose samples/out

echo "samples/radiance_by_elevation.py:"
PYTHONPATH=build/release/python NEPHOS_LIBRARY=build/release/lib/libnephos.so \
  /usr/bin/python3 samples/radiance_by_elevation.py --steps 6 -o samples/out/radiance_by_elevation.png

echo "The pictures (.exr, and a .png of each to look at) lie in $(pwd)/samples/out:"
ls -l samples/out/*.exr samples/out/*.png
