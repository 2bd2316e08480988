#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the job that `nephos job parallel` prints, by GNU parallel: parallel.sh PROGRAM
# One task fails at first, and is started again; the merged frames have the bits of one render. Installs Debian's parallel
# where it is missing.
set -eu
if ! command -v parallel >/dev/null; then
  [ "$(id -u)" -eq 0 ] || { echo "skipped: GNU parallel is not installed"; exit 77; }
  apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends parallel >/dev/null
fi
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
  echo "FAILED: $1"
  cat "$work/log"
  exit 1
}
mkdir "$work/my shots"
. "$(dirname "$0")/failing.sh"
put_failing_program "--tile 2/2"
cd "$work/my shots"
cat >"a scene.yaml" <<'SCENE'
camera: {resolution: [32, 18]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 33}}
render: {samples: 16}
output: {image: "a.####.exr"}
SCENE
"$program" render "a scene.yaml" -q --frames 1-5 -o 'whole.####.exr' >/dev/null
for threads in "" "--threads 1"; do
  rm -f a.*.exr "$work/failed"
  "$program" job parallel "a scene.yaml" --frames 1-5 --tiles 2 --chunk 2 $threads -- \
    --set 'output.preview=a "b" {1} & c.####.png' >job.sh
  sh job.sh >"$work/log" 2>&1 || fail "the job"
  [ -e "$work/failed" ] || fail "no task has failed"
  for frame in 1 2 3 4 5; do
    "$program" compare a.000$frame.exr whole.000$frame.exr --exact >"$work/log" || fail "frame $frame"
  done
done
echo "the frames have the bits of one render"
