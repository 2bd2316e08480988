# SPDX-License-Identifier: Apache-2.0
# A dome for other renderers: R, G, B alone, the sun in it or a light of its own.
echo 'sun: {elevation: 35 deg}' >scene.yaml
nephos sky scene.yaml -q -o sky.exr --resolution 32x16 >lines.txt
nephos info sky.exr | grep -E 'channels|disks'
nephos sky scene.yaml -q -o dome.exr --usd dome.usda --resolution 32x16 --center 90 >lines.txt
nephos info dome.exr | grep -E 'channels|disks'
grep -E 'def|file|rotate|format' dome.usda
nephos sky scene.yaml -q --usd dome.usda || echo $?
nephos sky scene.yaml -q -o dome.exr --usd dome.usd || echo $?
nephos sky scene.yaml -q -o dome.exr --center 400 || echo $?
