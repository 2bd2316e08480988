# SPDX-License-Identifier: Apache-2.0
# A stack that is too small is refused; one of the size that the refusal asks for is enough.
# Without sanitizers, whose frames are larger.
cat >scene.yaml <<'Y'
version: 1
camera: {position: [0, -6 km, 1200 m], look_at: [0, 0, 2200 m], fov: 60 deg, resolution: [8, 6]}
clouds: [{name: field, vdb: field.vdb, bake: {preset: cumulus_humilis, seed: 7, base: 1800 m, voxel: 100 m, extent: 2 km}}]
terrain: {ridges: {samples: 33}}
render: {samples: 4}
Y
for kilobytes in 64 1023; do
  (ulimit -s $kilobytes && nephos render scene.yaml -q -o no.exr) || echo $?
done
for integrator in march path; do
  (ulimit -s 1024 && nephos render scene.yaml -q --integrator $integrator -o $integrator.exr >/dev/null) || echo $?
done
(ulimit -s 1024 && nephos bake scene.yaml -q -o field.vdb >/dev/null && nephos info field.vdb >/dev/null) || echo $?
