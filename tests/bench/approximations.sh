# SPDX-License-Identifier: Apache-2.0
# The approximations of multiple scattering against the tracer on a cloud lit from all sides: prints the table of docs/accuracy.md.
#
#   sh approximations.sh NEPHOS FOLDER [PATTERN]
#
# NEPHOS   the program
# FOLDER   what disney.sh left there: scenes NAME.yaml and truths T_NAME.exr
# PATTERN  of the scenes wanted, such as 'black-hg-*-25?'; default those of the table
#
# Columns: the method; Σ picture / Σ truth − 1 with `render.look_gain: 1`; the gain that takes that away; with it,
# √(Σ d² / Σ L²) over means of 8×8 pixels, the truth's own variance taken out: what no exposure can mend.
set -eu
export LC_ALL=C
nephos=$1 folder=$2 pattern=${3:-}

compare() { # KEY, of the picture and the truth
  "$nephos" compare "$picture" "$truth" --json | tr -d '{}",' | tr ' ' '\n' | awk -v key="$1" '
    sub(":$", "") {name = $0; next}
    {value[name] = $0}
    END {
      rest = value["block_rms"] ^ 2 - value["noise_block_rms"] ^ 2
      print key == "bias" ? value["bias"] : sqrt(rest > 0 ? rest : 0)
    }'
}

render() { # METHOD GAIN
  "$nephos" render "$scene" --threads 1 -q --set "render.multiple_scattering=$1" --set "render.look_gain=$2" \
    --set 'render.derivative.distance=10 m' -o "$picture" >/dev/null
}

measure() { # NAME
  scene=$folder/$1.yaml truth=$folder/T_$1.exr picture=${TMPDIR:-/tmp}/approximation.$$.exr
  for method in none octaves softened_beer powder derivative ordinates; do
    render $method 1
    bias=$(compare bias)
    gain=1
    if [ $method != none ] && [ $method != ordinates ]; then
      gain=$(awk -v bias="$bias" 'BEGIN {printf "%.4g", 1 / (1 + bias)}')
      render $method "$gain"
    fi
    awk -v method=$method -v name="$1" -v bias="$bias" -v gain="$gain" -v rms="$(compare rms)" \
      'BEGIN {printf "| %s | %s | %+.1f %% | %.2g | %.1f %% |\n", name, method, 100 * bias, gain, 100 * rms}'
  done
  rm -f "$picture"
}

echo '| scene | method | bias | gain | block rms |'
echo '| --- | --- | --- | --- | --- |'
for name in black-hg-40-60f black-hg-40-25b black-hg-150-25f black-hg-150-25b; do
  case $name in
  ${pattern:-*}) measure $name ;;
  esac
done
