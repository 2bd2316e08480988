#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Holds the templates that `nephos job openjd` prints to the specification: openjd.sh PROGRAM
set -eu
python=/usr/bin/python3 # the one that Debian's packages are for
if ! $python -c 'import jsonschema, yaml' 2>/dev/null; then
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "python3-jsonschema and python3-yaml are required here"; exit 1; }
  echo "skipped: python3-jsonschema and python3-yaml are not installed"
  exit 77
fi
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat >"a scene.yaml" <<'SCENE'
clouds: [{bake: {extent: 1 km}}]
output: {image: "a.####.exr"}
SCENE

# STEPS OPTIONS…: a job of these steps and numbers of tasks
check() {
  steps=$1
  shift
  "$program" job openjd "a scene.yaml" "$@" >job.yaml
  $python "$here/openjd.py" "$here/openjd.schema.json" <job.yaml >found || { cat job.yaml; exit 1; }
  [ "$(tr '\n' ' ' <found)" = "$steps " ] || { echo "$*: is $(cat found), must be $steps"; exit 1; }
}
check "render: 6 tasks" --frames 1-9x2,20
check "render: 7 tasks" --frames -5--1,0,8
check "render: 6 tasks merge: 3 tasks" --frames 12,1-8,4 --chunk 4 --tiles 2 --checkpoint 5m -t 2 \
  -- --samples 8 --set 'output.preview=the "p" & <q>.####.png'
check "render: 1024 tasks" --frames 1-4096 --chunk 4
check "render: 256000 tasks merge: 4000 tasks" --frames 1-4000 --tiles 64

# A template that breaks a rule is found out, so that the checks above mean something.
for fault in 's/dependsOn: render/dependsOn: rendr/' 's/Param.Scene/Param.Scenes/' 's/"1-4096"/"1-9,5"/' 's/: 60}/: 601}/' \
  's/^name: .*/name: ""/' 's/command: nephos/cmd: nephos/' 's/objectType: FILE/objectType: FOLDER/'; do
  "$program" job openjd "a scene.yaml" --frames 1-4096 --tiles 2 | sed "$fault" >job.yaml
  ! $python "$here/openjd.py" "$here/openjd.schema.json" <job.yaml >found 2>&1 || { echo "not found: $fault"; exit 1; }
done
