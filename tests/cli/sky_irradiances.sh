# SPDX-License-Identifier: Apache-2.0
echo 'sun: {elevation: 35 deg}' >scene.yaml
nephos sky scene.yaml -q -o sky.exr --resolution 32x16 | sed -E 's/ [0-9.e-]+/ N/g; s/N nm, N nm, N nm/680 nm, 550 nm, 440 nm/'
nephos info sky.exr | head -n 1
