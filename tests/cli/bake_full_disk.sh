# SPDX-License-Identifier: Apache-2.0
# A disk that is full in the middle of the write, by a limit on the size of files: what was there stays, and nothing else.
cat >scene.yaml <<'END'
clouds:
  - {name: low, bake: {preset: cumulus_mediocris, seed: 7, extent: 2 km, voxel: 40 m, frame_time: 10 s}}
END
mkdir disk
full() (ulimit -f 64 && nephos bake scene.yaml -q -o disk "$@" || echo "exit $?"; ls -A disk)
full
full --levels 3 --half --velocity
full --frames 1-2
echo precious >disk/low.vdb
full
cat disk/low.vdb
