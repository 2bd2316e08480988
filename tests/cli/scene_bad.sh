# SPDX-License-Identifier: Apache-2.0
printf 'version: 1\nsun:\n  elevation: 95 deg\n' >scene.yaml
nephos render scene.yaml -o a.exr
