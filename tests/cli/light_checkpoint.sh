# SPDX-License-Identifier: Apache-2.0
# Light kept beside a checkpoint that is a pipe, a link, a folder, no light or damaged is set aside, and the light is
# computed again to the same bits. Files of other names beside a checkpoint stay.
cat >scene.yaml <<'YAML'
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg, resolution: [8, 6]}
sun: {elevation: 35 deg, azimuth: 120 deg}
atmosphere: none
clouds:
  - {name: field, bake: {preset: cumulus_humilis, seed: 7, base: 1800 m, voxel: 200 m, extent: 2 km}}
render: {integrator: march, samples: 1, multiple_scattering: ordinates}
YAML
nephos render scene.yaml -q -o whole.exr >/dev/null
resume() {
  timeout 60 nephos render scene.yaml -q -o a.exr --checkpoint 1s --resume >/dev/null || echo "exit $?"
  nephos compare a.exr whole.exr --exact | head -n 1
  ls -d a.* | grep -v '^a.exr$' || true
  rm -rf a.exr a.npart.light0-0.bad
}
echo pipe
mkfifo a.npart.light0-0
resume
echo link
ln -s /dev/zero a.npart.light0-0
resume
echo folder
mkdir a.npart.light0-0
resume
echo text
echo "no light at all, but longer than a header must be: $(seq 1 60 | tr '\n' ' ')" >a.npart.light0-0
resume
echo others
touch a.npart.lighting.txt a.npart.light0-0.bad a.npart.light1 a.npart.light3-1
resume
