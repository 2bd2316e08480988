# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
version: 1
camera: {position: [0, -8 km, 2 km]}
clouds:
  - {name: hero, vdb: hero.vdb, up: y, optical_depth: 40, phase: {two_lobe: {weight: 0.2}}}
output: {image: "out/frame.####.exr"}
END
nephos info scene.yaml --set sun.elevation="3 deg"
