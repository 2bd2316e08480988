# SPDX-License-Identifier: Apache-2.0
# All errors of a scene, then its files; several files and formats; mended copies.
data=$(dirname "$0")/../data
ln -s "$data" data
cat >bad.yaml <<'END'
camera: {fov: 1000 deg, bogus: 1}
sun: {elevation: 95 deg}
END
cat >good.yaml <<'END'
camera: {position: [0 m, -300 m, 40 m], look_at: [0, 0, 40 m], resolution: [16, 9]}
clouds:
  - {name: small, vdb: data/vdb/zipmask_half.vdb, extinction: 0.1 1/m, position: [0, 0, 10 m], voxel: 0.05 m}
  - {name: deep, vdb: data/vdb/zipmask_half.vdb, extinction: 0.1 1/m, position: [0, 0, -900 m]}
  - {name: gone, vdb: gone.vdb, extinction: 0.1 1/m}
END
try() {
  code=0
  nephos "$@" || code=$?
  echo "exit $code"
}
try check bad.yaml
try check good.yaml
try check good.yaml --set camera.fov=-3
try check data/vdb/zipmask_half.vdb data/vdb/frustum.vdb data/vdb/mask.vdb data/hostile/stray20000.vdb
try check "data/vdb/none.####.vdb" --json
try check data/vdb/zipmask_half.vdb --fix -o mended.vdb
try check data/vdb/zipmask_half.vdb --fix -o data/vdb/zipmask_half.vdb
try check data/vdb/zipmask_half.vdb --fix
try check data/vdb/zipmask_half.vdb -o mended.vdb
try check notes.txt
ls mended.vdb

# A table of a phase function that does not integrate to one, and a picture that is not there
printf 'angle_deg,value\n0,1\n180,1\n' >phase.csv
try check phase.csv missing.exr
