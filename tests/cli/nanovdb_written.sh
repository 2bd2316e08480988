# SPDX-License-Identifier: Apache-2.0
# .nvdb files are written by bake, export and a render that bakes; a rebake gives the same grids. USD refers to .vdb alone.
cat >scene.yaml <<'EOF'
version: 1
clouds:
  - name: field
    bake: {preset: cumulus_humilis, seed: 3, extent: 1 km, voxel: 50 m}
EOF
nephos bake scene.yaml -q -o low.nvdb >/dev/null
nephos bake --verify low.nvdb -q
nephos export scene.yaml -q -o placed.nvdb --levels 2 >/dev/null
ls ./*.nvdb
nephos export scene.yaml -q -o placed.nvdb --usd placed.usda || echo "exit $?"
nephos bake scene.yaml -q -o low.obj || echo "exit $?"
