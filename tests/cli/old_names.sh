# SPDX-License-Identifier: Apache-2.0
# Keys and options by their old names: a warning names the new one.
cat >scene.yaml <<'SCENE'
atmosphere: none
render: {look_gain: 2, integrator: path}
SCENE
nephos info scene.yaml --set render.splitting=adjoint | grep -e render.path -e gain
nephos render scene.yaml --splitting sometimes || [ $? -eq 2 ]
nephos render scene.yaml --path-guiding=none --dry-run -o a.exr
