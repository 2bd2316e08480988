# SPDX-License-Identifier: Apache-2.0
# How many times as long as the march the tracer takes to the march's own error: prints the table of
# docs/results/speed.md.
#
#   sh lead.sh NEPHOS CLOUD.vdb FOLDER [PATTERN [SAMPLES [RESOLUTION]]]
#
# NEPHOS      the program
# CLOUD       its densest column is given an optical depth of 40
# FOLDER      for scenes, pictures and references; a reference that is there is not rendered again
# PATTERN     of the scenes wanted, black-hg-40-SUN; default 'black-hg-40-*'
# SAMPLES     of each reference; default 16, which takes some eight CPU minutes a scene
# RESOLUTION  default 1920x1080
#
# Columns, over the whole frame: of one sample of the march and of the tracer, CPU seconds of one thread for everything,
# and √(Σ d² / Σ L²) over means of 8×8 pixels, the reference's own variance taken out. The tracer's error falls as
# 1/√N: the last is CPU of the one over that of the other, times the square of the errors' ratio. All three pictures have
# seeds of their own: a sample that is one of the reference's looks nearer to it than it is.
set -eu
export LC_ALL=C
nephos=$1 cloud=$2 folder=$3 pattern=${4:-*} samples=${5:-16} resolution=${6:-1920x1080}
mkdir -p "$folder"
. "$(dirname "$0")/disney_scenes.sh"

compute_error() { # PICTURE REFERENCE
  "$nephos" compare "$1" "$2" --json | tr -d '{}",' | tr ' ' '\n' | awk '
    sub(":$", "") {key = $0; next}
    {value[key] = $0}
    END {rest = value["block_rms"] ^ 2 - value["noise_block_rms"] ^ 2; print sqrt(rest > 0 ? rest : 0)}'
}

measure() { # NAME
  scene=$folder/$1.yaml reference=$folder/W_$1.exr march=$folder/M_$1.exr path=$folder/P_$1.exr
  [ -f "$reference" ] || render "$reference.cpu" "$scene" "$reference" --integrator path --samples "$samples" \
    --resolution "$resolution" --set 'output.aovs=[standard_error]'
  render "$march.cpu" "$scene" "$march" --integrator march --samples 1 --resolution "$resolution" --seed 1
  render "$path.cpu" "$scene" "$path" --integrator path --samples 1 --resolution "$resolution" --seed 2
  echo "$1" "$(cat "$march.cpu")" "$(compute_error "$march" "$reference")" "$(cat "$path.cpu")" "$(compute_error "$path" "$reference")" |
    awk '{printf "| %s | %.1f | %.1f %% | %.1f | %.1f %% | %.0f |\n", $1, $2, 100 * $3, $4, 100 * $5, $4 / $2 * ($5 / $3) ^ 2}'
}

echo '| scene | march, CPU s | error | tracer, CPU s | noise | times |'
echo '| --- | --- | --- | --- | --- | --- |'
for elevation in 60 25 4; do for side in f b; do
  name=black-hg-40-$elevation$side
  azimuth=190
  [ $side = f ] || azimuth=10
  case $name in
  $pattern)
    write_scene black hg 40 $elevation $azimuth >"$folder/$name.yaml"
    measure "$name"
    ;;
  esac
done; done
