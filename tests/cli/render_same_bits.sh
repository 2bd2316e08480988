# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
camera: {resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
END
nephos render scene.yaml -q -t 1 -o a.exr
nephos render scene.yaml -q -t 2 -o b.exr
nephos compare a.exr b.exr --exact >compared
sed 1,3d compared
