# SPDX-License-Identifier: Apache-2.0
# Clouds as .vdb and .usda.
try() { nephos "$@" -q || echo "exit code $?"; }
cat >clouds.yaml <<'END'
version: 1
clouds:
  - {name: low, bake: {preset: cumulus_humilis, seed: 3, extent: 1 km, voxel: 50 m, coverage: 0.8}}
END
try export clouds.yaml --usd low.usda
grep filePath low.usda
try export clouds.yaml --half --json -o half.vdb
try export clouds.yaml --set 'clouds[0]={name: again, vdb: low.vdb, extinction: 1}' -n -o again.vdb
try export clouds.yaml --set 'clouds[0]={vdb: low.vdb, extinction: 1}' -o low.vdb
try export clouds.yaml --frames 1-2 -o low.vdb
try export clouds.yaml --usd low.usd
try export clouds.yaml -o low.exr
