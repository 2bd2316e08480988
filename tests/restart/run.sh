#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Kills a batch of frames at random moments and starts it again: run.sh PROGRAM COUNT
# Each run but the last is ended by SIGKILL, which no program can answer. No frame that was finished may change or go,
# none may look finished that is not, and in the end all have the bits of a run that nothing stopped. Two processes
# write the same frames in every third run. Then a frame whose light takes longest is killed as often while it is solved
# for, and goes on from there.
set -u
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
count=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
cat >scene.yaml <<'SCENE'
camera: {position: [0 m, -3 km, 1100 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [48, 27]}
sun: {elevation: 50 deg, azimuth: 110 deg}
atmosphere: none
environment: {planet: none}
clouds:
  - {bake: {preset: cumulus_mediocris, extent: [3 km, 3 km], base: 1200 m, voxel: 150 m}, phase: {hg: 0.6}}
render: {samples: 24, integrator: path}
output: {image: "a.####.exr", aovs: [variance, transmittance]}
SCENE
render() { "$program" render scene.yaml -q --frames 1-3 "$@" >log 2>&1; }
fail() {
  echo "FAILED: $1"
  cat log
  exit 1
}
mkdir whole

render -o 'whole/a.####.exr' || fail "the whole render"
seconds=$(awk '{ sub(/ s,.*/, ""); sum += $NF } END { print sum }' log)

check_finished() {
  for picture in a.*.exr; do
    [ -e "$picture" ] || continue
    "$program" compare "$picture" "whole/$picture" --exact >compared 2>&1 || fail "$picture after kill $1"
  done
}

kills=0
while [ $kills -lt "$count" ]; do
  kills=$((kills + 1))
  render --checkpoint 0.02s --resume --skip-existing &
  first=$!
  second=
  if [ $((kills % 3)) = 0 ]; then
    render --checkpoint 0.03s --resume --skip-existing &
    second=$!
  fi
  sleep "$(awk -v seed="$(od -An -N4 -tu4 /dev/urandom)" -v most="$seconds" 'BEGIN { srand(seed); print 0.6 * most * rand() }')"
  for shell in $first $second; do
    for process in $(cat "/proc/$shell/task/$shell/children" 2>/dev/null) "$shell"; do kill -9 "$process" 2>/dev/null; done
  done
  wait 2>/dev/null
  check_finished $kills
  # All frames done: begin again, so that every kill has something to stop.
  if [ -e a.0003.exr ]; then rm -f a.*; fi
done
render --checkpoint 1s --resume --skip-existing || fail "the last run"
check_finished last
for frame in 1 2 3; do [ -e a.000$frame.exr ] || fail "frame $frame is missing"; done
ls a.*.npart >/dev/null 2>&1 && fail "a checkpoint is left"

cat >light.yaml <<'SCENE'
camera: {position: [0 m, -3 km, 1100 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [48, 27]}
sun: {elevation: 50 deg, azimuth: 110 deg}
atmosphere: none
environment: {planet: none, radiance: [0.01, 0.02, 0.03]}
clouds:
  - {bake: {preset: cumulus_mediocris, extent: [3 km, 3 km], base: 1200 m, voxel: 120 m}, phase: {hg: 0.6}}
render: {samples: 1, integrator: march, light_memory: 250 MB}
output: {image: "light.exr"}
SCENE
light() { "$program" render light.yaml -v -t 1 "$@" >log 2>&1; }
light -o whole/light.exr || fail "the whole render of light"
solving=0
kills=0
while [ $kills -lt "$count" ]; do
  kills=$((kills + 1))
  light --checkpoint 0.01s --resume &
  process=$!
  until ls light.npart.light* >/dev/null 2>&1 || [ -e light.exr ]; do sleep 0.01; done
  sleep "$(awk -v seed="$(od -An -N4 -tu4 /dev/urandom)" 'BEGIN { srand(seed); print 0.3 * rand() }')"
  for child in $(cat /proc/$process/task/$process/children 2>/dev/null) $process; do kill -9 "$child" 2>/dev/null; done
  wait 2>/dev/null
  if [ -e light.exr ]; then continue; fi
  light --checkpoint 60s --resume || fail "the light after kill $kills"
  if grep -q 'multiple scattering: resumed in band' log; then solving=$((solving + 1)); fi
  "$program" compare light.exr whole/light.exr --exact >compared 2>&1 || fail "the light after kill $kills"
  rm light.exr
done
[ $solving -gt 0 ] || fail "no kill fell into the solution of the light"
ls light.npart* >/dev/null 2>&1 && fail "light is left"
echo "$count kills, the same bits; $solving of them while light was solved for, which went on"
