# SPDX-License-Identifier: Apache-2.0
# A limit that comes before the first samples says in which stage, and is told by the exit code; one that comes later
# leaves a picture, whose header says so.
cat >baked.yaml <<'END'
atmosphere: none
clouds:
  - {name: field, bake: {preset: cumulus_mediocris, extent: 20 km, voxel: 15 m}}
END
cat >ground.yaml <<'END'
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 65}}
render: {samples: 16777216}
END
code=0
nephos render baked.yaml -q -t 1 -o a.exr --time-limit 0 2>messages || code=$?
sed -E "s/ [0-9.]+ s after/ N s after/; s/'(preparing cloud|baking)'/of the bake/" messages >&2
nephos render ground.yaml -q -o b.exr --time-limit 1
nephos info b.exr | grep -o 'cut at .* of 16777216 samples' | sed -E 's/at .* of/at N of/'
ls -A
exit $code
