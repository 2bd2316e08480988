# SPDX-License-Identifier: Apache-2.0
# Approximations of multiple scattering against the tracer, on a cloud lit from all sides: prints the table of
# docs/results/approximations.md.
#
#   sh approximations.sh NEPHOS FOLDER [PATTERN]
#
# NEPHOS   the program
# FOLDER   what disney.sh left there: scenes NAME.yaml and references T_NAME.exr
# PATTERN  of the scenes wanted, such as 'black-hg-*-25?'; default those of the table
#
# Columns: the method; Σ picture / Σ reference − 1 with `render.approximation_gain: 1`, and with the calibrated gain; with
# the latter, √(Σ d² / Σ L²) over means of 8×8 pixels, the reference's own variance taken out.
set -eu
export LC_ALL=C
nephos=$1 folder=$2 pattern=${3:-}

compare() { # KEY, of the picture and the reference
  "$nephos" compare "$picture" "$reference" --json | tr -d '{}",' | tr ' ' '\n' | awk -v key="$1" '
    sub(":$", "") {name = $0; next}
    {value[name] = $0}
    END {
      rest = value["block_rms"] ^ 2 - value["noise_block_rms"] ^ 2
      print key == "bias" ? value["bias"] : sqrt(rest > 0 ? rest : 0)
    }'
}

render() { # METHOD GAIN
  "$nephos" render "$scene" --threads 1 -q --set "render.multiple_scattering=$1" --set "render.approximation_gain=$2" \
    -o "$picture" >/dev/null
}

measure() { # NAME
  scene=$folder/$1.yaml reference=$folder/T_$1.exr picture=${TMPDIR:-/tmp}/approximation.$$.exr
  for method in none octaves softened_beer powder derivative ordinates; do
    render $method 1
    raw=$(compare bias)
    render $method auto
    awk -v method=$method -v name="$1" -v raw="$raw" -v bias="$(compare bias)" -v rms="$(compare rms)" \
      'BEGIN {printf "| %s | %s | %+.1f %% | %+.1f %% | %.1f %% |\n", name, method, 100 * raw, 100 * bias, 100 * rms}'
  done
  rm -f "$picture"
}

echo '| scene | method | bias, gain 1 | bias, calibrated gain | block rms |'
echo '| --- | --- | --- | --- | --- |'
for name in black-hg-40-60f black-hg-40-25b black-hg-150-25f black-hg-150-25b \
  black-dr-40-60f black-dr-40-25b; do
  case $name in
  ${pattern:-*}) measure $name ;;
  esac
done
