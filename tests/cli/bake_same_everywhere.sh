# SPDX-License-Identifier: Apache-2.0
# The same voxels and values for any instruction set and number of threads: fingerprints are one, and a file of each set
# is what another way of baking gives.
cat >low.yaml <<'END'
clouds: [{name: low, bake: {preset: cumulus_mediocris, seed: 7, extent: 600 m, voxel: 50 m, wind: [5 m/s, 2 m/s]}}]
END
cat >deck.yaml <<'END'
clouds: [{name: deck, bake: {preset: altostratus, seed: 7, extent: 4 km, voxel: 200 m}}]
END
for isa in x86-64 x86-64-v3 x86-64-v4; do
  for threads in 1 2 5; do
    mkdir $isa.$threads
    nephos bake low.yaml -q -o $isa.$threads --isa $isa -t $threads --levels 2 --velocity >>log
    nephos bake deck.yaml -q -o $isa.$threads --isa $isa -t $threads >>log
  done
  for name in low deck; do nephos bake -q --verify $isa.5/$name.vdb --isa x86-64 -t 3; done
done
# each grid's fingerprint stands in nine files
for name in low deck; do
  for folder in x86-64*; do nephos info $folder/$name.vdb | grep 'nephos:hash'; done | sort | uniq -c | awk '{print $1}'
done
