# SPDX-License-Identifier: Apache-2.0
# The same voxels and values for any instruction set and number of threads: of any two files one verifies the other's way.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_mediocris, seed: 7, extent: 1 km, voxel: 50 m, wind: [5 m/s, 2 m/s]}}
  - {name: deck, bake: {preset: altostratus, seed: 7, extent: 4 km, voxel: 200 m}}
END
for isa in x86-64 x86-64-v3 x86-64-v4; do
  for threads in 1 2 5; do
    mkdir $isa.$threads
    nephos bake scene.yaml -q -o $isa.$threads --isa $isa -t $threads --levels 2 --velocity >>log
  done
done
for file in x86-64*/*.vdb; do nephos bake -q --verify $file --isa x86-64 -t 3; done
for name in low deck; do
  for folder in x86-64*; do nephos info $folder/$name.vdb | grep 'nephos:hash'; done | sort | uniq -c | awk '{print $1}'
done
