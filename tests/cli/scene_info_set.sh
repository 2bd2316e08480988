# SPDX-License-Identifier: Apache-2.0
# Errors of several keys together are checked after --set as well.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m}}
END
try() { if nephos info scene.yaml --set "$1"; then exit 99; else [ $? -eq 3 ]; fi; }
try 'camera.look_at=[0, -6 km, 400 m]'
try 'clouds[1].name=low'
try 'clouds[0].bake.top=100 m'
try 'clouds[0].bake.profile=[0, 0.5, 0.4, 0.8, 1]'
try 'sun.time=2026-06-21T16:00Z'
try 'output.scale=3'
try 'render.wavelengths=7'
nephos info scene.yaml --set 'camera.fov=30 deg' | grep camera.fov
