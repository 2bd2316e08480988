# SPDX-License-Identifier: Apache-2.0
cat >scene.yaml <<'END'
camera: {resolution: [4096, 4096]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
render: {integrator: march, samples: 4096}
END
timeout --preserve-status -s INT 0.5 nephos render scene.yaml -q -o a.exr || code=$?
ls -A
exit $code
