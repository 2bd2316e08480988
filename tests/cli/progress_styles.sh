# SPDX-License-Identifier: Apache-2.0
# Each style of progress, over a batch: one fraction for the whole of it, which never falls and ends at 1; JSON alone in
# the style json, warnings and failed frames included; the lines that Tractor and OpenJD read; the log file.
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 33}}
clouds: [{name: a, vdb: "b.####.vdb", extinction: 1, missing: error}]
render: {samples: 1}
output: {image: "a.####.exr"}
YAML
echo 'clouds: [{bake: {extent: 1 km, voxel: 100 m, coverage: 1}}]' >bake.yaml
nephos bake bake.yaml -q -o b.0001.vdb >/dev/null
cp b.0001.vdb b.0003.vdb
rises() { sort -c -n && echo rises; }
for style in json lines alf openjd none; do
  echo "== $style"
  nephos render scene.yaml --frames 1-3 --progress $style --json --log log.$style >results 2>messages || echo "exit $?"
  case $style in
    json)
      sed -n 's/.*"fraction": \([0-9.]*\),.*/\1/p' messages | rises
      grep '"stage": "writing"' messages | tail -n 1 | sed 's/"seconds": [0-9.]*/"seconds": N/'
      python3 -c 'import json,sys; [json.loads(line) for line in sys.stdin]' <messages
      grep '"level": "error"' messages
      ;;
    lines) sed -n 's/.* \([0-9]*\) %, .*/\1/p' messages | rises; grep 'frame 3 (3 of 3), writing 100 %' messages | sed 's/,[^,]* s,.*//' ;;
    alf) sed -n 's/^ALF_PROGRESS \([0-9]*\)%$/\1/p' messages | rises; grep 'ALF_PROGRESS 100%' messages ;;
    openjd) sed -n 's/^openjd_progress: //p' messages | rises; grep '^openjd_fail' messages; tail -n 2 messages | grep -v fail ;;
    none) cat messages ;;
  esac
  sed 's/"seconds".*"hash": "[0-9a-f]*"/"seconds and hash"/' results
done
sed -E 's/^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}Z //; s/[0-9.]+ s, [0-9]+ MB/N/' log.json | grep -v %
nephos render scene.yaml -q --log none/log || echo "exit $?"
