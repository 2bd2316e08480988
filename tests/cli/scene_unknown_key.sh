# SPDX-License-Identifier: Apache-2.0
printf 'camera: {fow: 50 deg}\n' >scene.yaml
nephos render scene.yaml -o a.exr
