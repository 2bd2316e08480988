# SPDX-License-Identifier: Apache-2.0
echo 'version: 1' >scene.yaml
nephos render scene.yaml -o a.tiff
