# SPDX-License-Identifier: Apache-2.0
echo 'camera: {fov: 30 deg}' | nephos info - --json | head -n 12
