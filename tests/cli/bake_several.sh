# SPDX-License-Identifier: Apache-2.0
echo 'clouds: [{bake: {extent: 1 km, voxel: 50 m}}, {name: high, bake: {base: 3 km, extent: 1 km, voxel: 50 m}}]' >scene.yaml
nephos bake scene.yaml -q -n
nephos bake scene.yaml -q -o one.vdb
