# SPDX-License-Identifier: Apache-2.0
# Too little address space for OpenVDB and its threads: a bake fails with a message and code 1 and leaves nothing, or does
# all, at any limit. Without sanitizers: theirs would take all of it.
cat >scene.yaml <<'YAML'
clouds:
  - {name: low, bake: {preset: cumulus_mediocris, seed: 7, extent: 2 km, voxel: 16 m}}
YAML
mkdir out
# check LIMIT OPTIONS…: all or nothing
check() {
  code=0 limit=$1
  shift
  (ulimit -v $limit && nephos bake scene.yaml -q -t 2 -o out "$@") >done 2>message || code=$?
  left=$(ls -A out)
  case "$code $(wc -l <message) $left" in
  '1 1 ' | '0 0 low.vdb') ;;
  *) echo "$limit: exit $code, left $left, $(cat message)" ;;
  esac
  rm -f out/low.vdb
}
# There is no room for OpenVDB, then for threads beside it, and then, in finer voxels, for the tree that is written.
for limit in 140000 160000 180000 200000 208000 216000 224000 232000 240000; do check $limit; done
sheet='--set clouds[0].bake.preset=altostratus --set clouds[0].bake.voxel=9m' # more voxels in less time
for limit in 235000 250000 265000 300000; do check $limit $sheet; done
(ulimit -v 140000 && nephos bake scene.yaml -q -t 2 -o out 2>message) || echo "exit $?"
sed 's/needs [0-9]* MB/needs N MB/' message
