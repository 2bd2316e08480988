# SPDX-License-Identifier: Apache-2.0
# Samples by a target error against the same number for all, over four scenes and both integrators: prints the table of
# docs/results/adaptive.md.
#
#   sh adaptive.sh BENCH_ADAPTIVE NEPHOS CLOUD.vdb FOLDER [RESOLUTION [SEEDS [SECONDS]]]
#
# BENCH_ADAPTIVE  bench_adaptive, of the same build as NEPHOS, which bakes
# CLOUD           wdas_cloud_sixteenth.vdb
# FOLDER          for scenes and clouds
# RESOLUTION      default 120,68
# SEEDS           pictures of each target; default 4
# SECONDS         CPU time of the longest picture of the same number for all; default 2
set -eu
export LC_ALL=C
bench=$1 nephos=$2 cloud=$3 folder=$4 resolution=${5:-120,68} seeds=${6:-4} seconds=${7:-2}
samples_folder=$(cd "$(dirname "$0")/../../samples" && pwd)
mkdir -p "$folder/out"
cd "$folder"

for name in sunset cumulus_field above_the_deck; do
  sed -E "s/resolution: \[960, 540\]/resolution: [$resolution]/; /^output/d; /^render/d" \
    "$samples_folder/$name.yaml" >$name.yaml
  echo 'output: {aovs: [sample_count]}' >>$name.yaml
  "$nephos" bake $name.yaml -q >/dev/null
done
cat >disney.yaml <<END
version: 1
camera: {position: [0, -700 m, 1600 m], look_at: [0, 0, 1640 m], fov: 40 deg, resolution: [$resolution]}
sun: {elevation: 25 deg, azimuth: 10 deg}
clouds: [{vdb: $cloud, up: y, optical_depth: 40, position: [0, 0, 1500 m], phase: {hg: 0.85}}]
output: {aovs: [sample_count]}
END

cat <<END
| scene | target % | noise asked % | noise % | ratio | samples | least | largest | for all | gain | gain in CPU time |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
END
for name in sunset cumulus_field above_the_deck disney; do
  "$bench" "$name, march" $name.yaml render.quality=draft render.integrator=march "$seeds" "$seconds" 0.2 0.1 0.03
done
for name in cumulus_field disney; do
  "$bench" "$name, path" $name.yaml render.integrator=path render.atmosphere=tables "$seeds" "$seconds" 0.4 0.2
done
