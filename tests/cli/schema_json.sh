# SPDX-License-Identifier: Apache-2.0
nephos schema --json | grep -A 8 '"key": "camera.fov"'
