# SPDX-License-Identifier: Apache-2.0
# A preview is described as what it is, another PNG as the height field that it may be.
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
output: {image: "a.####.exr", preview: "a.####.png", exposure: 3 EV}
YAML
nephos render scene.yaml -q --frames 12 >out
nephos info a.0012.png
nephos info a.0012.png --json
nephos render scene.yaml -q --frames 13 --set output.view=raw --set output.preview_bits=16 >out
nephos info a.0013.png
head -c 60 a.0012.png >cut.png
nephos info cut.png || echo "exit $?"
