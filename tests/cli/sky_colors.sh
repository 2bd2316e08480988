# SPDX-License-Identifier: Apache-2.0
echo 'sun: {elevation: 35 deg}' >scene.yaml
set -- -q --resolution 32x16 --set render.wavelengths=6
nephos sky scene.yaml "$@" -o sky.exr | sed -E 's/ [0-9.e-]+/ N/g'
nephos sky scene.yaml "$@" --json --set output.color_space=acescg | sed -E 's/[0-9.e-]+([],])/N\1/g'
nephos info sky.exr | grep -E 'colorSpace|white'
nephos sky scene.yaml "$@" -o bands.exr --set render.wavelengths=3 --set output.color_space=bands >lines.txt
nephos compare bands.exr sky.exr
