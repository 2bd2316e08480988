# SPDX-License-Identifier: Apache-2.0
# Stated error, for people and for programs; every number is written as N.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: altostratus, extent: 2 km, voxel: 100 m, coverage: 0.85}}
END
plain() { sed -E 's/-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?/N/g; s/  +/ /g'; }
nephos bake scene.yaml -q --error --half --prune 0.001 | plain
nephos bake scene.yaml -q --error --json | tee out.json | plain
/usr/bin/python3 -c 'import json; e = json.load(open("out.json"))["error"]; print(e["half"] == e["pruning"], e["total"] == e["voxel"])'
nephos bake scene.yaml -n --error
