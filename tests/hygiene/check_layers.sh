#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_layers.sh SOURCE_DIR: who includes whom, against the table of docs/design.md; and that each foreign library has one door.
set -eu
cd "$1"
fail=0
complain() { echo "$1" >&2; fail=1; }

# A module, then what it may include besides itself and core.
layers='core:
optics:
noise:
volume: optics noise
image:
mesh:
cloud: optics noise volume image mesh
terrain: noise image mesh
atmosphere: optics image
world: optics noise volume atmosphere terrain
transport: optics noise volume atmosphere terrain world
caches: optics noise volume atmosphere terrain world transport
integrate: optics noise volume atmosphere terrain world transport caches
scene: optics noise volume image mesh cloud terrain atmosphere
plan: optics volume image cloud terrain atmosphere transport caches integrate scene
stages: optics volume image cloud terrain atmosphere world caches integrate scene plan
frame: volume image integrate scene plan stages
parts: image scene plan frame
render: scene plan stages frame parts
export: noise volume image cloud atmosphere integrate scene plan stages render
probe: volume atmosphere integrate scene plan stages frame
report: optics noise volume image mesh cloud terrain atmosphere world transport caches integrate scene plan stages frame
check: optics noise volume image mesh cloud terrain atmosphere world transport caches integrate scene plan stages render'

for folder in src/*/; do
  module=$(basename "$folder")
  [ "$module" != python ] || continue # no C of its own
  line=$(echo "$layers" | grep "^$module:") || { complain "src/$module is not in the table of modules"; continue; }
  allowed=" $module core ${line#*:} "
  [ "$module" = core ] && allowed=' core '
  for include in $(grep -rhoE '^#include "[^"]+"' "$folder" | cut -d'"' -f2 | sort -u); do
    case $include in
    */*) ;;
    *) complain "src/$module includes \"$include\": name the module too"; continue ;;
    esac
    case "$allowed" in
    *" ${include%%/*} "*) ;;
    *) complain "src/$module includes \"$include\", and may include only:$allowed" ;;
    esac
  done
done

# The solution of the multiple scattering is opaque: others include this header of transport.
door='transport/scattering_field\.h'
bad=$(grep -rnE '^#include "transport/' src --include='*.[ch]' | grep -v '^src/transport/' | grep -vE "\"$door\"" || true)
[ -z "$bad" ] || complain "outside src/transport only scattering_field.h of it is included: $bad"
bad=$(grep -nE '^#include "transport/' src/transport/scattering_field.h |
  grep -vE '"transport/(ordinates|peak_column|transport_fold)\.h"' || true)
[ -z "$bad" ] || complain "a public header of src/transport includes a private one: $bad"

for folder in cli samples; do
  [ -d $folder ] || continue
  bad=$(grep -rnE --include='*.[ch]' '^#include "[^"]*/' $folder || true)
  [ -z "$bad" ] || complain "$folder may include nothing of src: $bad"
done

# A pattern of headers, then the only files that may name them. The sun's file and the reader of NetCDF have a lock because their
# libraries keep state in variables of their own.
doors='openvdb/ src/volume/(vdb_(shim.cpp|archive.h|conversion.h|failure.h|mending.h|reading.h|writing.h)|nvdb_writing.h)
nanovdb/ src/volume/nvdb_(header|writing).h
blosc\.h src/volume/vdb_packing.h
zlib\.h src/volume/vdb_packing.h|src/image/png_rows.c
tbb/ src/volume/vdb_failure.h
embree src/terrain/terrain.c
assimp/ src/mesh/assimp_reader.c
(netcdf|hdf5) src/volume/netcdf_reader.c
gdal/ src/terrain/gdal_(files|names|reader|references)\.[ch]
OpenColorIO/ src/image/ocio_shim.cpp
openexr src/image/image_exr(_read|_write)?\.[ch]
png\.h src/image/image_png.c
yaml\.h src/scene/scene_file.c
jansson\.h src/core/json.c
xxhash\.h src/core/hash.c
libnova/ src/atmosphere/celestial.c
pthread\.h src/core/parallel.c|src/atmosphere/celestial.c|src/volume/netcdf_(reader|program).c|cli/view/view_(messages.h|picture.c|variants.c|worker.c)
threads\.h none'
echo "$doors" | while read -r header door; do
  grep -rlEi --include='*.[ch]' --include='*.cpp' "^#include <(OpenEXR/)?$header" src cli samples 2>/dev/null |
    grep -vxE "$door" | sed "s#\$#: includes <$header…>, whose one door is $door#"
done >"${TMPDIR:-/tmp}/nephos-doors.$$"
bad=$(cat "${TMPDIR:-/tmp}/nephos-doors.$$")
rm -f "${TMPDIR:-/tmp}/nephos-doors.$$"
[ -z "$bad" ] || complain "$bad"
exit $fail
