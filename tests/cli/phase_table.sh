# SPDX-License-Identifier: Apache-2.0
# A tabulated phase function: rendered, missing, not normalised.
cat >scene.yaml <<END
version: 1
camera: {position: [0 m, -200 m, 5 m], look_at: [0 m, 0 m, 60 m], resolution: [4, 4]}
atmosphere: {preset: none}
clouds:
  - name: puff
    bake: {extent: [100 m, 100 m], base: 20 m, thickness: 100 m, voxel: 20 m, coverage: 1}
    phase: {table: phase.csv}
render: {samples: 1}
output: {image: puff.exr}
END
try() { code=0; nephos render scene.yaml -q || code=$?; echo "$code"; }
try
printf 'angle_deg,value\n0,0.2\n180,0.1\n' >phase.csv
try
printf 'angle_deg,value\n0,0.1194\n180,0.0398\n' >phase.csv
try
