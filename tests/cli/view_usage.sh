# SPDX-License-Identifier: Apache-2.0
# Command lines and scenes that are refused, and a view that Ctrl-C ends.
cat >scene.yaml <<'END'
version: 1
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
END
for options in '' '-' 'scene.yaml --port 65536' 'scene.yaml --port x' 'missing.yaml' 'scene.yaml --listen example.org' \
  'scene.yaml --set camera.fov=200' 'scene.yaml --size 64x36'; do
  code=0
  nephos view $options || code=$?
  echo "view $options: $code"
done
code=0
timeout --foreground --preserve-status -s INT 1 nephos view scene.yaml >address || code=$?
sed -E 's/:[0-9]+\/#[0-9a-f]{32}$/:PORT\/#TOKEN/' address
echo "ended: $code"
timeout --foreground --preserve-status -s INT 1 nephos view scene.yaml --listen 0.0.0.0 >address
sed -E 's/:[0-9]+\/#[0-9a-f]{32}$/:PORT\/#TOKEN/' address
