# SPDX-License-Identifier: Apache-2.0
# A picture too dim, or too bright, for half floats is written as float; the warning's scale makes halves do.
cat >scene.yaml <<'END'
camera: {resolution: [4, 2]}
atmosphere: none
environment: {planet: none, radiance: 1e-6}
output: {image: dim.exr, color_space: bands}
END
nephos render scene.yaml -q
nephos info dim.exr | grep channels
nephos render scene.yaml -q --set output.scale=1024 -o scaled.exr
nephos info scaled.exr | grep channels
nephos render scene.yaml -q --set environment.radiance=1e6 -o bright.exr
nephos info bright.exr | grep channels
