#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# run.sh BUILD_DIR CMAKE COMPILER: installs into a folder of its own, moves that, then builds and runs a foreign project
# against it, through CMake and through pkg-config.
set -eu
source=$(cd "$(dirname "$0")" && pwd)
build=$1 cmake=$2 compiler=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cmake" --install "$build" --prefix "$folder/first" >"$folder/install.log" || { cat "$folder/install.log"; exit 1; }
for file in man/man1/nephos.1 man/man1/nephos-render.1 man/man5/nephos-scene.5 bash-completion/completions/nephos; do
  [ -s "$folder/first/share/$file" ] || { echo "not installed: share/$file"; exit 1; }
done
mv "$folder/first" "$folder/prefix" # an installed tree does not know where it was

"$cmake" -S "$source" -B "$folder/cmake" -G Ninja -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_C_COMPILER="$compiler"
"$cmake" --build "$folder/cmake"
# The shared library finds its module beside itself; a program that has the static one is told where it is.
pc=$(find "$folder/prefix" -name nephos.pc)
PKG_CONFIG_PATH=$(dirname "$pc")
export PKG_CONFIG_PATH
libdir=$(pkg-config --variable=libdir nephos)
"$folder/cmake/from_c" "$folder/cloud.vdb"
"$folder/cmake/from_c_static" "$folder/cloud.vdb" "$libdir/nephos"
"$folder/cmake/from_c_static" "$folder/cloud.vdb" || [ $? = 3 ] # not told, it may find none
"$folder/cmake/from_cpp"

"$compiler" -std=c11 -Wall -Wextra -Werror "$source/user.c" $(pkg-config --cflags --libs nephos) \
  -Wl,-rpath,"$libdir" -o "$folder/by_pkg_config"
"$folder/by_pkg_config" "$folder/cloud.vdb"
"$compiler" -std=c11 "$source/user.c" $(pkg-config --cflags nephos) -L"$libdir" \
  -Wl,-Bstatic -lnephos -Wl,-Bdynamic $(pkg-config --libs --static nephos | sed s/-lnephos//) -o "$folder/by_pkg_config_static"
"$folder/by_pkg_config_static" "$folder/cloud.vdb" "$libdir/nephos"
