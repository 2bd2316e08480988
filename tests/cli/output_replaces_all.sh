# SPDX-License-Identifier: Apache-2.0
# -o names all that is written: the scene's preview is not, unless a .png is named as well.
cat >scene.yaml <<'END'
version: 1
camera: {resolution: [4, 2]}
atmosphere: none
environment: {planet: none, radiance: 0.1}
output: {image: scene.exr, preview: scene.png}
END
nephos render scene.yaml -q -o only.exr
ls
nephos render scene.yaml -q -o both.exr -o both.png
ls
