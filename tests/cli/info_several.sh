# SPDX-License-Identifier: Apache-2.0
echo 'camera: {fov: 30 deg}' >a.yaml
echo 'camera: {fov: 300 deg}' >b.yaml
nephos info a.yaml b.yaml a.yaml | grep -e == -e fov
nephos info --json a.yaml a.yaml | grep -e '^[][,]' -e fov
nephos info b.yaml a.yaml >/dev/null
