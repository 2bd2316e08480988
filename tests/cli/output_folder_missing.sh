# SPDX-License-Identifier: Apache-2.0
echo 'output: {image: "out/a.exr"}' >scene.yaml
nephos render scene.yaml
