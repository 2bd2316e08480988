# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
camera: {resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
output: {image: "a.####.exr"}
END
nephos render scene.yaml -q --frames 1-2
nephos render scene.yaml -q --json -o b.exr -o b.png
ls
