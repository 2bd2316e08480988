#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# deb.sh BUILD_DIR CPACK: makes the Debian packages, installs them into an empty folder, and uses what is there: the
# program bakes, Python reads its cloud, and a C program is built by the installed headers and library.
set -eu
command -v dpkg-shlibdeps >/dev/null || {
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "dpkg-dev is required here"; exit 1; }
  exit 77
}
source=$(cd "$(dirname "$0")" && pwd)
build=$1 cpack=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

(cd "$build" && "$cpack" -G DEB -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip -B "$folder/packages") >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
ls "$folder/packages" | grep '\.deb$' | sed 's/_.*//'

root=$folder/root
mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates"
: >"$root/var/lib/dpkg/status"
# Libraries that the packages depend on are in the folder of the machine.
dpkg --root="$root" --force-not-root --force-depends --force-script-chrootless --install "$folder"/packages/*.deb \
  >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
dpkg-query --admindir="$root/var/lib/dpkg" -W -f '${Package}: ${db:Status-Status}\n'
for package in libnephos-dev nephos python3-nephos; do
  dpkg-query --admindir="$root/var/lib/dpkg" -W -f '${Depends}\n' $package | grep -q 'libnephos0\.1 (=' ||
    { echo "$package does not depend on the library"; exit 1; }
done
dpkg-query --admindir="$root/var/lib/dpkg" -W -f '${Depends}\n' libnephos0.1 | grep -q libopenvdb ||
  { echo "the library does not depend on OpenVDB"; exit 1; }

usr=$root/usr
"$usr/bin/nephos" --version
printf 'clouds: [{name: a, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 40 m}}]\n' >"$folder/scene.yaml"
"$usr/bin/nephos" bake "$folder/scene.yaml" -q -o "$folder/cloud.vdb" | sed 's/:.*//'
"$usr/bin/nephos" info "$folder/cloud.vdb" | head -n 1 | sed "s|$folder/||"
(cd / && PYTHONPATH=$usr/lib/python3/dist-packages /usr/bin/python3 -c 'import sys, nephos
print(nephos.__version__, nephos.__file__.startswith(sys.argv[2]), nephos.lib._name.startswith(sys.argv[2]))
print(nephos.Volume.load(sys.argv[1]).info["name"])' "$folder/cloud.vdb" "$root")
for file in man/man1/nephos-render.1 man/man5/nephos-scene.5 bash-completion/completions/nephos; do
  [ -s "$usr/share/$file" ] || { echo "not installed: share/$file"; exit 1; }
done

PKG_CONFIG_PATH=$(dirname "$(find "$usr" -name nephos.pc)")
export PKG_CONFIG_PATH
libdir=$(pkg-config --variable=libdir nephos)
cc -std=c11 -Wall -Wextra -Werror "$source/user.c" $(pkg-config --cflags --libs nephos) -Wl,-rpath,"$libdir" \
  -o "$folder/user"
"$folder/user" "$folder/from_c.vdb" >/dev/null
