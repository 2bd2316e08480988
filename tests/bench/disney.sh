# SPDX-License-Identifier: Apache-2.0
# The march against the tracer on a cloud that is lit from all sides: prints the table of docs/results/march.md.
#
#   sh disney.sh NEPHOS CLOUD.vdb FOLDER [PATTERN [SAMPLES]]
#
# NEPHOS   the program
# CLOUD    its densest column is given an optical depth of 40 and of 150
# FOLDER   for scenes, pictures and references; a reference that is there is not rendered again
# PATTERN  of the scenes wanted, SKY-PHASE-DEPTH-SUN, such as 'black-hg-*b'; default all 48
# SAMPLES  of each reference; default 256
#
# Columns: Σ march / Σ reference − 1 with the reference's standard error; √(Σ d² / Σ L²) over means of 8×8 pixels, the
# reference's own variance taken out; that variance's root; CPU seconds of one thread for everything, loading and tables
# included. The sun's disk and the sky behind are left out of both pictures. The march has 16 samples: with its own 4, the
# noise of so few samples at a bright rim in pixels so large would be counted as well.
set -eu
export LC_ALL=C
nephos=$1 cloud=$2 folder=$3 pattern=${4:-*} samples=${5:-256}
mkdir -p "$folder"

. "$(dirname "$0")/disney_scenes.sh"

measure() { # NAME
  scene=$folder/$1.yaml reference=$folder/T_$1.exr march=$folder/M_$1.exr
  [ -f "$reference" ] || render "$reference.cpu" "$scene" "$reference" --integrator path --samples "$samples" \
    --set 'output.aovs=[standard_error]'
  render "$march.cpu" "$scene" "$march" --integrator march --samples 16
  "$nephos" compare "$march" "$reference" --json | tr -d '{}",' | tr ' ' '\n' >"$folder/compared"
  awk -v name="$1" -v march="$(cat "$march.cpu")" -v reference="$(cat "$reference.cpu")" '
    sub(":$", "") {key = $0; next}
    {value[key] = $0}
    END {
      rest = value["block_rms"] ^ 2 - value["noise_block_rms"] ^ 2
      printf "| %s | %+.1f ± %.1f %% | %.1f %% | %.1f %% | %.1f | %.0f |\n", name, 100 * value["bias"],
             100 * value["noise_bias"], 100 * sqrt(rest > 0 ? rest : 0), 100 * value["noise_block_rms"], march, reference
    }' "$folder/compared"
}

echo '| scene | bias | block rms | reference'"'"'s noise in it | march, CPU s | reference, CPU s |'
echo '| --- | --- | --- | --- | --- | --- |'
for sky in black sky; do for phase in hg dr; do for depth in 40 150; do for elevation in 60 25 4; do for side in f b; do
  name=$sky-$phase-$depth-$elevation$side
  azimuth=190
  [ $side = f ] || azimuth=10
  case $name in
  $pattern)
    write_scene $sky $phase $depth $elevation $azimuth >"$folder/$name.yaml"
    measure "$name"
    ;;
  esac
done; done; done; done; done
