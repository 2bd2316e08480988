# SPDX-License-Identifier: Apache-2.0
# A bake that the process may not have the memory for. Without sanitizers: theirs would take all of it.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: stratus, extent: 6 km, voxel: 5 m}}
END
ulimit -v 500000
nephos bake scene.yaml -q -t 1 2>message || echo "exit $?"
sed 's/need [0-9.]* GB/need N GB/' message
ls
