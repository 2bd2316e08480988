# SPDX-License-Identifier: Apache-2.0
# A batch stopped by SIGTERM leaves with 75 and goes on; SIGUSR1 leaves a snapshot that can be read; frames that are
# there are skipped by their headers, not by their names.
cat >scene.yaml <<'SCENE'
camera: {position: [0, 0, 500 m], look_at: [0, 1 km, 700 m], resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
clouds: [{name: block, bake: {extent: 1 km, voxel: 200 m, coverage: 1}, position: [0, 2 km, 500 m]}]
render: {samples: 4, integrator: path}
output: {image: "a.####.exr"}
SCENE
nephos render scene.yaml -q --frames 1-2 | sed 's/, .*//'
nephos render scene.yaml -q --frames 1-3 --skip-existing | sed 's/, .*//'
nephos render scene.yaml -q --frames 1-3 --skip-existing --json | cut -d, -f1-3
nephos render scene.yaml -q --frames 1 --skip-existing --seed 5 | sed 's/, .*//'
nephos render scene.yaml -q --tile 1/2 -o a.0002.exr | sed 's/, .*//'
nephos render scene.yaml -q --frames 2 --skip-existing | sed 's/, .*//'
# The render takes far longer than the rest of the case.
nephos render scene.yaml -q --samples 5000 -o b.exr --checkpoint 0.05s >/dev/null 2>err &
until [ -e b.npart ]; do sleep 0.05; done
kill -USR1 $!
until [ -e b.snapshot.exr ]; do sleep 0.05; done
kill -TERM $!
code=0
wait $! || code=$?
echo "exit $code"
tail -n 1 err
ls b.*
nephos info b.snapshot.exr | head -n 1
nephos merge b.npart -o x.exr 2>&1 | sed 's/with .* %/with N %/'
nephos render scene.yaml -q --samples 64 -o c.exr --resume --checkpoint 0 || echo "exit $?"
