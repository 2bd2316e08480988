# SPDX-License-Identifier: Apache-2.0
# What real files look like: each cloud, its longest side 1 km long and its densest column 60 deep, and each height field
# from 1 km above its top, as one sheet (ImageMagick's montage). Files that a render refuses are left out and named.
#
#   sh files_pictures.sh NEPHOS FOLDER OUT.png
#
# FOLDER   files, in any depth
set -eu
export LC_ALL=C
nephos=$(realpath "$1") folder=$(realpath "$2") out=$(realpath "$3")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

cat > cloud.yaml <<'YAML'
version: 1
camera: {position: [0 m, -2300 m, 600 m], look_at: [0 m, 0 m, 800 m], fov: 50 deg, resolution: [320, 180]}
sun: {elevation: 35 deg, azimuth: 240 deg}
render: {samples: 16}
YAML
cat > terrain.yaml <<'YAML'
version: 1
camera: {fov: 60 deg, resolution: [320, 180]}
sun: {elevation: 25 deg, azimuth: 250 deg}
render: {samples: 16}
YAML

# Longest side of the first grid that holds anything, in metres.
measure() {
  "$nephos" info "$1" 2>/dev/null | awk '/^  bounds/ {
    gsub(/[(),]/, " ")
    for (axis = 2; axis < 5; axis++) if ($(axis + 4) - $axis > longest) longest = $(axis + 4) - $axis
    print longest
    exit
  }'
}

# show NAME SCENE KEY=VALUE…
show() {
  name=$1 scene=$2
  shift 2
  for set in "$@"; do
    shift
    set -- "$@" --set "$set"
  done
  if ! "$nephos" render "$scene" -q --set "output.image=$name.exr" --set "output.preview=$name.png" "$@" 2>"$name.txt"
  then echo "left out: $(cat "$name.txt")"; fi
}

for file in $(cd "$folder" && find . -name '*.vdb' | sort); do
  path=$folder/$file
  side=$(measure "$path")
  [ -n "$side" ] || { echo "left out: $file holds nothing to see"; continue; }
  show "$(basename "$file")" cloud.yaml "clouds[0].vdb=$path" "clouds[0].optical_depth=60" \
    "clouds[0].scale=$(awk "BEGIN { print 1000 / $side }")" "clouds[0].pivot=center" "clouds[0].position=[0 m, 0 m, 800 m]" \
    "clouds[0].up=$(case $file in *arnold*|*wdas*|*vpt*) echo y ;; *) echo z ;; esac)"
done
for file in $(cd "$folder" && find . -name '*.hgt' -o -name '*.tif' | sort); do
  path=$folder/$file
  place=$("$nephos" info "$path" | sed -n 's/^center *\([-0-9.]*\), *\([-0-9.]*\) deg.*/{latitude: \1 deg, longitude: \2 deg}/p')
  top=$("$nephos" info "$path" | awk '/^elevation/ { print $4 }')
  show "$(basename "$file")" terrain.yaml "terrain.heightfield=$path" "place=$place" \
    "camera.position=[0 m, -15 km, $((${top%.*} + 1000)) m]" "camera.look_at=[0 m, 0 m, $((${top%.*} / 2)) m]"
done
for picture in *.png; do
  set -- "$@" -label "${picture%.png}" "$picture"
done
shift 3
montage -pointsize 11 "$@" -tile 4x -geometry 240x135+2+2 -strip -depth 8 "$out"
