# SPDX-License-Identifier: Apache-2.0
# Light through planes of a scene: an empty one, and requests that are refused.
try() { code=0; "$@" || code=$?; echo "$code"; }
cat >empty.yaml <<'YAML'
version: 1
camera: {position: [0 m, 0 m, 5 km], look_at: [1 m, 0 m, 0 m]}
sun: {elevation: 30 deg, azimuth: 90 deg, irradiance: 2, angular_radius: 0 deg}
atmosphere: {preset: none}
environment: {planet: none}
YAML
nephos probe field empty.yaml --heights 1000,0 --paths 64 -q
nephos probe field empty.yaml --heights 0 --paths 64 -q --integrator march --set sun.elevation='90 deg' -o out.csv
cat out.csv
try nephos probe field empty.yaml -q
try nephos probe field empty.yaml --heights 1,,2 -q
try nephos probe field empty.yaml --heights '1 km' -q
try nephos probe field empty.yaml --heights 1e9 -q
try nephos probe field empty.yaml --heights 1 --path-guiding auto -q
try nephos probe field missing.yaml --heights 1 -q
try nephos probe i3rc empty.yaml -q
try nephos probe i3rc . -q --method trace
