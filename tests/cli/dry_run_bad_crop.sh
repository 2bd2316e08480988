# SPDX-License-Identifier: Apache-2.0
echo 'version: 1' >scene.yaml
nephos render scene.yaml -n -o a.exr --crop 10,10,5,5
