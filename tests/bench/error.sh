# SPDX-License-Identifier: Apache-2.0
# Errors that renders state, against the true ones, over 12 scenes: prints the table of docs/results/error.md.
#
#   sh error.sh NEPHOS BENCH_ERROR CLOUD.vdb FIRE.vdb FOLDER [SAMPLES [SEEDS]]
#
# NEPHOS       the program
# BENCH_ERROR  bench_error, of the same build
# CLOUD        wdas_cloud_sixteenth.vdb; FIRE usd_densityAndHeat.vdb
# FOLDER       for scenes, pictures and references; a reference that is there is not rendered again
# SAMPLES      of the pictures; default "4"
# SEEDS        of the references by path, 128 samples each; default "1 2 3 4"; an even number
set -eu
export LC_ALL=C
nephos=$1 bench=$2 cloud=$3 fire=$4 folder=$5 samples=${6:-4} seeds=${7:-1 2 3 4}
samples_folder=$(cd "$(dirname "$0")/../../samples" && pwd)
mkdir -p "$folder"
cd "$folder"

write_sample() { # NAME: a sample, small and without files of its own
  sed -E 's/resolution: \[960, 540\]/resolution: [96, 54]/; s#out/##; /^output/d' "$samples_folder/$1.yaml" >"$1.yaml"
}

write_cloud() { # NAME SKY PHASE DEPTH ELEVATION AZIMUTH ALBEDO
  height=0
  [ "$2" = black ] || height=1500
  cat >"$1.yaml" <<END
version: 1
camera:
  {position: [0, -700 m, $((height + 100)) m], look_at: [0, 0, $((height + 140)) m], fov: 40 deg, resolution: [96, 54]}
sun: {elevation: $5 deg, azimuth: $6 deg}
clouds: [{vdb: $cloud, up: y, optical_depth: $4, position: [0, 0, $height m], phase: $3, albedo: $7}]
END
  [ "$2" != black ] || printf 'atmosphere: none\nenvironment: {planet: none}\n' >>"$1.yaml"
}

for name in cumulus_field above_the_deck sunset night; do write_sample $name; done
echo 'output: {scale: 1048576}' >>night.yaml
write_cloud disney_sky sky '{hg: 0.85}' 40 25 10 0.999995
write_cloud disney_deep sky '{hg: 0.85}' 150 25 10 0.999995
write_cloud disney_dark black '{hg: 0.85}' 40 60 190 0.8
write_cloud disney_grey sky isotropic 10 40 90 '[0.6, 0.75, 0.9]'
write_cloud disney_glory black '{droplets: {diameter: 20 um}}' 40 8 180 0.999995
cat >fog.yaml <<END
version: 1
camera: {position: [0, -700 m, 600 m], look_at: [0, 0, 620 m], fov: 70 deg, resolution: [96, 54]}
sun: {elevation: 30 deg, azimuth: 150 deg}
clouds: [{name: fog, vdb: fog.vdb, bake: {preset: stratus, seed: 4, extent: [4 km, 4 km], base: 300 m, voxel: 30 m}}]
END
cat >congestus.yaml <<END
version: 1
camera: {position: [0 m, -7 km, 800 m], look_at: [0 m, 0 m, 1700 m], fov: 60 deg, resolution: [96, 54]}
sun: {elevation: 38 deg, azimuth: 150 deg}
atmosphere: {ground_albedo: [0.05, 0.06, 0.07]}
clouds: [{vdb: congestus.vdb, bake: {preset: cumulus_congestus, seed: 3, extent: [8 km, 8 km], voxel: 50 m}}]
END
cat >fire.yaml <<END
version: 1
camera: {position: [0, -50 m, 12 m], look_at: [0, 0, 14 m], fov: 45 deg, resolution: [96, 54]}
sun: {elevation: -30 deg}
atmosphere: none
environment: {planet: none}
clouds:
  - {name: fire, vdb: $fire, position: [0, 0, 0], scale: 1, extinction: 0.4 1/m, albedo: 0.8, phase: {hg: 0.5},
     emission: {temperature: heat, kelvin: 1200 K, offset: 700 K}}
END

# The same pixels as floats, whatever the radiances.
render() { # OUTPUT OPTIONS…
  output=$1
  shift
  "$nephos" render "$@" -q --threads 1 --set output.pixel_type=float -o part.exr >part.txt
  mv part.exr "$output"
}

echo '| scene, samples | true error, % | noise | bias | stated error, % | noise | bias | stated / true |'
echo '| --- | --- | --- | --- | --- | --- | --- | --- |'
for name in disney_dark disney_glory disney_sky disney_deep disney_grey fog fire sunset night congestus cumulus_field \
  above_the_deck; do
  references=
  for seed in $seeds; do
    [ -f "R_$name.$seed.exr" ] || render "R_$name.$seed.exr" $name.yaml --integrator path --samples 128 --seed "$seed"
    references="$references R_$name.$seed.exr"
  done
  for count in $samples; do
    for seed in 1 2; do render "E_$name.$seed.exr" $name.yaml --samples "$count" --seed $seed; done
    # shellcheck disable=SC2086
    "$bench" "$name, $count" "E_$name.1.exr" "E_$name.2.exr" $references
  done
done
