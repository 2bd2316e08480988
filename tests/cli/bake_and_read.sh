# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m, coverage: 0.8}}
END
nephos bake scene.yaml -q
nephos bake scene.yaml -q -o other.vdb
mkdir folder
nephos bake scene.yaml -q -o folder --json
nephos bake scene.yaml -n
nephos info low.vdb | grep -c .  >/dev/null
ls . folder
