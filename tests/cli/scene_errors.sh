# SPDX-License-Identifier: Apache-2.0
# Ten different errors of a scene are told together, in the order of the file.
cat >scene.yaml <<'SCENE'
version: 2
place: {latitude: 44 deg}
camera: {fow: 50 deg, resolution: [960, x]}
sun: {elevation: 95 deg, elevation: 3}
clouds:
  - {name: bare}
  - {name: hero, vdb: hero.vdb, extinction: 1, optical_depth: 3}
terrain: {albedo: 0.2}
render: {splitting: sometimes}
output: {scale: 3}
SCENE
nephos render scene.yaml -o a.exr
