# SPDX-License-Identifier: Apache-2.0
# Ten copies of a cloud against a thousand that cover as many pixels: prints the table of docs/results/economy.md#copies.
#
#   sh places.sh NEPHOS CLOUD.vdb FOLDER [RESOLUTION]
#
# NEPHOS      the program
# CLOUD.vdb   a cloud with y up, such as a sixteenth of Disney's
# FOLDER      for scenes and pictures
# RESOLUTION  default 160x90
#
# Copies are turned and enlarged at random over 7 × 7 km; a thousand are a tenth as large as ten. CPU time of one thread,
# and memory.
set -eu
export LC_ALL=C
nephos=$1 cloud=$(realpath "$2") folder=$3 resolution=${4:-160x90}
mkdir -p "$folder"

write_scene() { # COUNT SCALE
  awk -v count="$1" -v scale="$2" 'BEGIN {
    srand(3)
    print "x_m,y_m,z_m,rotation_deg,scale"
    for (i = 0; i < count; i++) {
      x = 7000 * rand() - 3500; y = 7000 * rand() - 3500; turn = 360 * rand()
      printf "%.1f,%.1f,1000,%.2f,%.4f\n", x, y, turn, scale * (0.7 + 0.7 * rand())
    }
  }' >"$folder/$1.csv"
  cat >"$folder/$1.yaml" <<END
camera: {position: [0 m, -9 km, 3 km], look_at: [0, 0, 1200 m], fov: 50 deg}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds: [{vdb: "$cloud", up: y, voxel: 20 m, extinction: 0.02 1/m, places: $1.csv}]
render: {samples: 4}
output: {image: $1.exr}
END
}

measure() { # COUNT INTEGRATOR METHOD
  /usr/bin/time -f '%U %M' -o "$folder/time.txt" "$nephos" render "$folder/$1.yaml" -q --threads 1 \
    --resolution "$resolution" --set "render.integrator=$2" --set "render.multiple_scattering=$3" >/dev/null 2>&1
  awk -v count="$1" -v name="$2, $3" '{printf "| %s | %s | %.1f | %.0f |\n", name, count, $1, $2 / 1024}' \
    "$folder/time.txt"
}

write_scene 10 1
write_scene 1000 0.1
echo '| light | copies | CPU time, s | memory, MB |'
echo '| --- | --- | --- | --- |'
for count in 10 1000; do measure $count march ordinates; done
for count in 10 1000; do measure $count march octaves; done
for count in 10 1000; do measure $count path ordinates; done
