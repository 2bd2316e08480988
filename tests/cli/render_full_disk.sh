# SPDX-License-Identifier: Apache-2.0
# A disk that is full in the middle of the write, by a limit on the size of files, whose signal ends nothing.
cat >scene.yaml <<'YAML'
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [320, 180]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 129}}
YAML
full() (ulimit -f 8 && nephos render scene.yaml -q --samples 1 "$@" || echo "exit $?"; ls -A disk)
mkdir disk
full -o disk/a.exr
full -o disk/a.png
echo precious >disk/a.exr
full -o disk/a.exr
cat disk/a.exr
