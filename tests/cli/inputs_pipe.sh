# SPDX-License-Identifier: Apache-2.0
# A pipe to which nobody writes is refused, by whatever key it is named; a scene may come through one.
mkfifo pipe.vdb pipe.png pipe.csv pipe.exr
try() { timeout -k 1 20 nephos "$@" -q || echo "exit code $?"; }
printf "version: 1\nsun: {elevation: 30}\ncamera: {resolution: [16, 9]}\n" >scene.yaml
try render scene.yaml -n --set 'clouds=[{vdb: pipe.vdb, extinction: 1}]' -o out.exr
try render scene.yaml --set 'clouds=[{vdb: pipe.vdb, extinction: 1}]' -o out.exr
try export scene.yaml --set 'clouds=[{vdb: pipe.vdb, extinction: 1}]' -o copy.vdb
try render scene.yaml --set 'terrain={heightfield: pipe.png}' -o out.exr
try render scene.yaml --set 'terrain={heightfield: pipe.exr}' -o out.exr
try render scene.yaml --set 'clouds=[{vdb: pipe.vdb, extinction: 1, places: pipe.csv}]' -o out.exr
try check pipe.vdb pipe.png
cat scene.yaml | try render - -n -o out.exr
