# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
clouds: [{name: low, bake: {extent: 1 km, voxel: 50 m}}]
atmosphere: none
END
nephos render scene.yaml --explain --resolution 64x32
