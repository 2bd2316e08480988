# SPDX-License-Identifier: Apache-2.0
echo 'version: 1' >scene.yaml
try() { if nephos render scene.yaml -n -o a.exr --set "$1"; then exit 99; else [ $? -eq 3 ]; fi; }
try sun.elevatoin=3
try sun.elevation=95
try render.samples=4.5
try 'clouds[3].name=x'
try 'clouds[0].name=x'
