# SPDX-License-Identifier: Apache-2.0
# Levels of detail with velocities, regions and errors: each file is verified, and the voxels of two regions are those
# of the whole. Every number of the error is written as N.
cat >scene.yaml <<'END'
version: 1
camera: {position: [-1 km, 0 m, 1500 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [64, 36]}
clouds:
  - {name: low, bake: {preset: stratocumulus, extent: 2 km, base: 1200 m, thickness: 1 km, voxel: 50 m, coverage: 0.5, levels: 2, level_pixels: 8,
                      wind: [5 m/s, 0]}}
END
plain() { sed -E 's/-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?/N/g; s/  +/ /g'; }
voxels() { nephos info "$1" --json | /usr/bin/python3 -c 'import json, sys; print(json.load(sys.stdin)["grids"][0]["active_voxels"])'; }
mkdir whole west east
nephos bake scene.yaml -q --velocity --error --half -o whole/low.vdb | plain
nephos bake scene.yaml -q --error --json -o whole/plain.vdb >out.json
/usr/bin/python3 -c 'import json; e = json.load(open("out.json"))["error"]; print(sum(l["points"] for l in e["levels"]) == e["points"])'
nephos bake scene.yaml -q --velocity --half --region=-9e3,-9e3,-9e3,111,9e3,9e3 -o west/low.vdb >/dev/null
nephos bake scene.yaml -q --velocity --half --region=111,-9e3,-9e3,9e3,9e3,9e3 -o east/low.vdb >/dev/null
for level in low.vdb low.lod1.vdb; do
  nephos bake -q --verify west/$level
  nephos info whole/$level | grep -c "grid 'vel'"
  echo $(($(voxels whole/$level) - $(voxels west/$level) - $(voxels east/$level)))
done
nephos bake scene.yaml -q --levels 2 || echo $?
