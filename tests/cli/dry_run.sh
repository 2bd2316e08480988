# SPDX-License-Identifier: Apache-2.0
mkdir out
echo 'output: {image: "out/a.####.exr", preview: "out/a.####.png"}' >scene.yaml
nephos render scene.yaml -n --frames 1-5x2,10
nephos render scene.yaml -n --tile 2/4
nephos render scene.yaml -n -o "b.##.png"
ls out
