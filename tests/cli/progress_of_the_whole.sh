# SPDX-License-Identifier: Apache-2.0
# The fraction is that of the whole frame: over all stages it never falls, and it is 1 when the files are there and not
# before.
cat >scene.yaml <<'END'
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [16, 9]}
atmosphere: {preset: earth, tolerance: 0.1}
terrain: {ridges: {samples: 65}}
clouds:
  - {name: a, extinction: 1 1/m, bake: {preset: cumulus_mediocris, model: hero, extent: 800 m, voxel: 50 m}}
END
nephos render scene.yaml -o a.exr --progress json 2>messages >frames
grep -c '"stage": "solving multiple scattering"' messages >/dev/null
sed -n 's/.*"fraction": \([0-9.]*\),.*/\1/p' messages | sort -c -n
tail -n 1 messages | grep -o '"stage": "writing", "fraction": 1.0000'
grep -c '"fraction": 1.0000' messages
