# SPDX-License-Identifier: Apache-2.0
# Frames by numbers below 0, ranges that overlap, keys by frame, and what is wrong with them.
cat >scene.yaml <<'END'
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
animate:
  camera.position.0: [[1, 0 m], [101, 1 km]]
  camera.fov: {interpolation: smooth, keys: [[1, 50 deg], [51, 30 deg], [101, 60]]}
output: {image: "a.####.exr"}
END
nephos render scene.yaml -q --frames -2-0,3-1 || echo "exit code $?"
nephos render scene.yaml -q --frames -2--1,-1-1x2
nephos info scene.yaml --frame 26 | grep -E "camera.(position|fov)"
nephos info scene.yaml --frame 26 --set camera.position.0=5 | grep camera.position || true
nephos info scene.yaml --frame 26 --set "camera.position=[1, 2, 3]" | grep camera.position
nephos info scene.yaml --frame 26 --set "animate.camera.roll={interpolation: step, keys: [[1, 5], [26, 10]]}" | grep camera.roll
nephos render scene.yaml -q --frames 26 -o alone.exr
nephos render scene.yaml -q --frames 1,14,26 -o b.##.exr
nephos compare alone.exr b.26.exr --exact | grep differ
cat >bad.yaml <<'END'
camera: {position: [0, -3 km, 900 m]}
animate:
  camera.positon: [[1, 2]]
  camera.kind: [[1, 2]]
  camera.fov: [[5, 30 deg], [3, 20 deg]]
  camera.roll: [[5, 30 m], [6, 20 deg]]
  camera.position.3: [[1, 2 m]]
  clouds[2].scale: [[1, 2]]
  render.samples: [[1, 2]]
  camera.position: [[1, 2]]
  camera.look_at: {interpolation: cubic, keys: []}
  camera.shift: []
  camera.far: {kys: 1}
  camera.roll: [[1, 2]]
  camera.shift.1: [[1]]
  camera.shift.0: [[often, 1]]
END
nephos info bad.yaml || echo "exit code $?"
