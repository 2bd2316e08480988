# SPDX-License-Identifier: Apache-2.0
nephos schema --json | grep -A 15 '"key": "camera.fov"'
