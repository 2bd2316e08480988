# SPDX-License-Identifier: Apache-2.0
# Values that no cloud and no fire can have: refused, with what is allowed.
printf 'version: 1\nclouds: [{name: c, vdb: c.vdb, extinction: 1}]\n' >scene.yaml
try() { if nephos render scene.yaml -n -o a.exr --set "clouds[0].$1"; then exit 99; else [ $? -eq 3 ]; fi; }
try 'phase={hg: 1}'
try 'phase={hg: -1}'
try 'phase={hg: .nan}'
try 'phase={two_lobe: {forward: 1.5}}'
try 'phase={draine: {g: 1}}'
try 'phase={droplets: {diameter: 80 um}}'
try 'albedo=1.01'
try 'albedo=[1, 1, -0.1]'
try 'extinction=-1'
try 'emission={kelvin: -1}'
try 'emission={strength: .inf}'
try 'emission={absorption: -1}'
try 'emission={temperature: none}'
