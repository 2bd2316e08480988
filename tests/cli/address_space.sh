# SPDX-License-Identifier: Apache-2.0
# Without sanitizers, which take address space of their own. Arenas of threads leave room for the work.
cat >scene.yaml <<'YAML'
camera: {position: [0, -2 km, 1 km], look_at: [0, 0, 1 km], resolution: [32, 18]}
atmosphere: none
clouds: [{bake: {preset: cumulus_humilis, extent: 1 km, voxel: 80 m}}]
render: {samples: 4, integrator: march}
YAML
for limit in 150000 175000 200000 225000 300000; do
  (ulimit -v $limit && nephos render scene.yaml -q -t 4 -o a.exr >log) || echo "exit $?"
done
