# SPDX-License-Identifier: Apache-2.0
# Error and CPU time of frames that take pixels from the frame before, and of upsampled ones, over the speed of the
# camera: prints the tables of docs/results/history.md.
#
#   sh history.sh NEPHOS FOLDER
#
# FOLDER  for scenes, pictures and references, of 64 samples a pixel and of 256 by paths, which are made once
#
# Errors are those a pixel of frame 17, the 16th after one that is rendered whole. Columns: pixels that the clouds move
# by in a frame, or what else moves; share of the pixels rendered with history; errors of the whole frame, with history
# at 1 pixel in 16 and in 4, at half and at quarter resolution, and of both at once. CPU times are those of a frame from
# the 2nd to the 17th: milliseconds of its pixels, and of all of it.
set -eu
export LC_ALL=C
nephos=$1 folder=$2
history='--set render.history=reproject'
mkdir -p "$folder"
cd "$folder"

write_scene() { # NAME PIXELS [TRACKS [BAKE_KEYS]]
  far=$(awk -v pixels="$2" 'BEGIN { print 100 * pixels * 2 * 6000 * 0.5206 / 160 }') # at 6 km, tan(55 deg / 2)
  cat >"$1.yaml" <<END
camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 1300 m], fov: 55 deg, resolution: [160, 90]}
sun: {elevation: 35 deg, azimuth: 120 deg}
terrain: {ridges: {samples: 257, relief: 900 m, seed: 2}, width: 16 km, albedo: [0.12, 0.16, 0.08]}
clouds:
  - {name: field, bake: {preset: cumulus_humilis, seed: 3, extent: 5 km, base: 1300 m, voxel: 40 m, coverage: 0.5${4:-}}}
animate: {camera.position.0: [[1, 0 m], [101, $far m]], camera.look_at.0: [[1, 0 m], [101, $far m]]${3:-}}
render: {samples: 4, multiple_scattering: octaves}
END
}

render() { # SCENE PICTURE OPTIONS
  scene=$1 picture=$2
  shift 2
  "$nephos" render "$scene.yaml" -v -t 1 -o "$picture" "$@" 2>&1
}

print_error() { # SCENE KIND OPTIONS
  scene=$1 kind=$2
  shift 2
  render "$scene" p.exr --frames 17 "$@" >log
  "$nephos" compare p.exr "reference_$scene$kind.exr" --json | tr -d '{},' | tr ' ' '\n' | awk '
    name == "\"pixel_error\":" { printf " %.1f |", 100 * $1 }
    { name = $1 }'
}

print_row() { # TITLE SCENE KIND REFERENCE_SAMPLES OPTIONS
  title=$1 scene=$2 kind=$3 samples=$4
  shift 4
  [ -f "reference_$scene$kind.exr" ] ||
    render "$scene" "reference_$scene$kind.exr" --frames 17 "$@" --samples "$samples" >/dev/null
  render "$scene" p.exr --frames 17 $history "$@" >log
  awk -v title="$title" '/pixels: .*rendered/ { share = $3 } END { printf "| %s | %s |", title, share }' log
  print_error "$scene" "$kind" "$@"
  print_error "$scene" "$kind" $history "$@"
  print_error "$scene" "$kind" $history --set render.history_update=4 "$@"
  print_error "$scene" "$kind" --set render.upsample=2 "$@"
  print_error "$scene" "$kind" --set render.upsample=4 "$@"
  print_error "$scene" "$kind" $history --set render.upsample=2 "$@"
  echo
}

print_head() { # FIRST_COLUMN
  echo "| $1 | rendered, % | whole | 1 in 16 | 1 in 4 | half | quarter | half, 1 in 16 |"
  echo '| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |'
}

measure_cpu_s() { # SCENE FRAMES OPTIONS
  scene=$1 frames=$2
  shift 2
  (
    render "$scene" p.##.exr --frames "$frames" "$@" >log
    times
  ) | awk 'END { split($1, t, "m"); print 60 * t[1] + t[2] }'
}

print_cpu() { # TITLE SCENE OPTIONS
  title=$1 scene=$2
  shift 2
  first=$(measure_cpu_s "$scene" 1 "$@")
  all=$(measure_cpu_s "$scene" 1-17 "$@")
  awk -v title="$title" -v rest="$(echo "$all $first" | awk '{ print $1 - $2 }')" '
    /integrator: predicted/ && n++ { for (i = 1; i < NF; i++) if ($i == "measured") pixels += $(i + 1) }
    END { printf "| %s | %.1f | %.1f |\n", title, 1000 * pixels / 16, 1000 * rest / 16 }' log
}

for pixels in 0 0.5 1 2 4 8 16; do write_scene "move_$pixels" $pixels; done
write_scene sun 0 ', sun.elevation: [[1, 30 deg], [101, 50 deg]], sun.azimuth: [[1, 110 deg], [101, 140 deg]]'
write_scene wind 0 '' ', wind: [20 m/s, 0 m/s], frame_time: 1 s'

print_head 'march, pixels a frame'
for pixels in 0 0.5 1 2 4 8 16; do print_row $pixels "move_$pixels" '' 64; done
echo
print_head 'path, pixels a frame'
for pixels in 0 1 8; do
  print_row $pixels "move_$pixels" _path 256 --set render.integrator=path --set render.atmosphere=tables
done
echo
print_head 'march, camera at rest'
print_row 'sun, 0.3 deg a frame' sun '' 64
print_row 'clouds, half a pixel a frame' wind '' 64

cat <<END

| one pixel a frame | CPU of pixels, ms | CPU of all, ms |
| --- | ---: | ---: |
END
for integrator in march path; do
  options="--set render.integrator=$integrator"
  [ $integrator = march ] || options="$options --set render.atmosphere=tables"
  print_cpu "$integrator, whole" move_1 $options
  print_cpu "$integrator, 1 in 16" move_1 $options $history
  print_cpu "$integrator, 1 in 4" move_1 $options $history --set render.history_update=4
  print_cpu "$integrator, half" move_1 $options --set render.upsample=2
  print_cpu "$integrator, quarter" move_1 $options --set render.upsample=4
  print_cpu "$integrator, half, 1 in 16" move_1 $options $history --set render.upsample=2
done
