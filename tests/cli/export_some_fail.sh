# SPDX-License-Identifier: Apache-2.0
# A frame that cannot be exported lets the others go on: the layer has those that are there. Without a temperature that the
# scene names, export and its dry run fail as a render does.
try() { nephos "$@" -q || echo "exit code $?"; }
cat >bake.yaml <<'END'
version: 1
clouds:
  - {name: low, bake: {preset: cumulus_humilis, seed: 3, extent: 1 km, voxel: 50 m, coverage: 0.8}}
END
nephos bake bake.yaml -q -o a.0001.vdb >bake.log
cp a.0001.vdb a.0003.vdb
echo 'no grid' >a.0002.vdb
cat >scene.yaml <<'END'
version: 1
clouds: [{name: low, vdb: "a.####.vdb", extinction: 1}]
END
try export scene.yaml --frames 1-3 -o b.####.vdb --usd b.usda 2>errors
sed 's/a.0002.vdb: .*/a.0002.vdb: .../' errors
ls b.*
grep -c filePath b.usda
grep '[0-9]: @' b.usda
try export scene.yaml --frames 2-2 -o c.####.vdb --usd c.usda 2>/dev/null
try export scene.yaml --frames 1-3 -n -o d.####.vdb 2>/dev/null
for option in '' -n; do
  try export scene.yaml --frames 1 $option --set 'clouds[0].emission={temperature: heat}' -o e.vdb
done
ls c.* e.* 2>/dev/null || echo 'nothing else'
