# SPDX-License-Identifier: Apache-2.0
# Paths of pictures, and of clouds baked on the way, are checked before any work.
echo 'output: {image: "out/a.exr"}' >scene.yaml
nephos render scene.yaml || [ $? -eq 5 ]
echo 'clouds: [{vdb: "out/a.vdb", bake: {voxel: 80 m}}]' >clouds.yaml
nephos render clouds.yaml -o a.exr
