# SPDX-License-Identifier: Apache-2.0
# Motion blur against the mean of many sub-frames, each with its own light: prints a table of docs/results/animation.md.
#
#   sh motion_blur.sh NEPHOS BENCH_ERROR [SUBFRAMES [SAMPLES [INTEGRATOR]]]
#
# Columns: the motion; error a pixel of one blurred picture against the mean of SUBFRAMES pictures at even times of the
# exposure, with 95 % bounds; the same of a picture without blur; CPU seconds of the blurred picture and of the
# sub-frames. Blurred and sub-frames have SAMPLES a pixel in all; a second seed of each keeps their noise out.
# BENCH_ERROR is bench_error of the same build. Needs oiiotool.
set -eu
export LC_ALL=C
nephos=$1
bench=$(realpath "$2")
count=${3:-64}
samples=${4:-256}
integrator=${5:-march}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

write_scene() { # CLOUD
  cat <<END
frame_rate: 24
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], fov: 50 deg, resolution: [96, 54]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds:
  - {name: field, $1}
render: {integrator: $integrator}
output: {image: "out.####.exr"}
END
}

field='bake: {preset: cumulus_humilis, seed: 3, extent: 2 km, voxel: 40 m, coverage: 0.6'

render() { # OPTIONS
  "$nephos" render -q -t 1 "$@" >/dev/null 2>&1
}

measure_cpu() { # OPTIONS
  ( render "$@"; times ) | awk 'END { split($1, t, "m"); printf "%.1f", 60 * t[1] + t[2] }'
}

# Keys whose value is `middle` at the frame's time, and `change` more a frame later: at the two ends of a track.
write_tracks() { # FIRST_FRAME FIRST_TIME LAST_FRAME LAST_TIME, then lines KEY MIDDLE CHANGE UNIT from the input
  printf 'animate:\n'
  awk -v f="$1" -v s="$2" -v g="$3" -v t="$4" '{
    printf "  %s: [[%s, %.9g %s], [%s, %.9g %s]]\n", $1, f, $2 + s * $3, $4, g, $2 + t * $3, $4 }'
}

# The mean of pictures NAME.0001.exr and on, as NAME.exr.
average() { # NAME
  oiiotool "$1.0001.exr" --ch R,G,B $(for k in $(seq -f %04g 2 "$count"); do echo "$1.$k.exr --ch R,G,B --add"; done) \
    --mulc "$(awk -v n="$count" 'BEGIN { printf "%.17g", 1 / n }')" -d float -o "$1.exr"
}

get_bias() { # PICTURE SECOND
  "$bench" row "$1" "$2" sub.exr sub2.exr | awk -F ' *[|] *' '{ printf "%s %%", $5 }'
}

print_row() { # NAME SUBFRAMES_CPU
  cpu=$(measure_cpu blur.yaml --frames 1 --samples "$samples" -o blur.exr)
  render blur.yaml --frames 1 --samples "$samples" --seed 7 -o blur2.exr
  render blur.yaml --frames 1 --samples "$samples" --set camera.motion_blur=none -o still.exr
  render blur.yaml --frames 1 --samples "$samples" --set camera.motion_blur=none --seed 7 -o still2.exr
  average sub
  average sub2
  echo "| $1 | $(get_bias blur.exr blur2.exr) | $(get_bias still.exr still2.exr) | $cpu | $2 |"
}

# By tracks: sub-frames are frames of a scene whose tracks go as far as the exposure.
measure_tracks() { # NAME, KEYS as of write_tracks
  first=$(awk -v n="$count" 'BEGIN { print 0.5 * (0.5 / n - 0.5) }')
  { write_scene "$field}"; echo "$2" | write_tracks 0 -1 2 1; } >blur.yaml
  { write_scene "$field}"; echo "$2" | write_tracks 1 "$first" "$count" "$(echo "$first" | awk '{ print -$1 }')"; } >sub.yaml
  blur
  render sub.yaml --frames "1-$count" --samples $((samples / count)) --seed 7 -o sub2.####.exr
  print_row "$1" "$(measure_cpu sub.yaml --frames "1-$count" --samples $((samples / count)) -o sub.####.exr)"
}

blur() {
  sed -i 's/resolution: \[96, 54\]/&, motion_blur: {shutter: 0.5}/' blur.yaml
}

# By growth and wind: a bake for each sub-frame, of which 20 s are a frame.
measure_bakes() {
  changing="$field, wind: [4, 1], lifetime: 600 s, time: 1000 s"
  write_scene "$changing}" >sub.yaml
  bakes_cpu=0
  for k in $(seq "$count"); do
    number=$(printf %04d "$k")
    time=$(awk -v k="$k" -v n="$count" 'BEGIN { printf "%.9g", 1000 + 20 * 0.5 * ((k - 0.5) / n - 0.5) }')
    set -- sub.yaml --frames 1 --samples $((samples / count)) --set "clouds[0].bake.time=$time s"
    one=$(measure_cpu "$@" --seed "$k" -o "sub.$number.exr")
    render "$@" --seed $((k + count)) -o "sub2.$number.exr"
    bakes_cpu=$(echo "$bakes_cpu $one" | awk '{ print $1 + $2 }')
  done
  write_scene "$changing, frame_time: 20 s}" >blur.yaml
  blur
  print_row "a baked cloud that grows in a wind, by the wind alone" "$bakes_cpu"
  "$nephos" bake sub.yaml -q --velocity -o field.vdb >/dev/null
  write_scene 'vdb: field.vdb, extinction: 1 1/m, velocity_scale: 480' >blur.yaml # 20 s for a frame of 1/24 s
  blur
  print_row "the same from a file, by its velocities" "$bakes_cpu"
}

measure_tracks "the camera pans by 12 pixels" "camera.look_at.0 0 750 m"
measure_tracks "the camera turns about its view by 10 deg" "camera.roll 0 20 deg"
measure_tracks "the camera flies 150 m about the clouds" "camera.position.0 0 300 m
camera.look_at.0 0 0 m"
measure_tracks "the cloud moves by 300 m, 10 pixels" "clouds[0].position.0 0 600 m
clouds[0].position.1 0 0 m
clouds[0].position.2 800 0 m"
measure_bakes
