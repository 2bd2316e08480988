#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the cases of this folder: run.sh [--update | --shard I/N] PROGRAM [CASE…]
# A case is NAME.sh, run in an empty folder with `nephos` in the path; NAME.out, NAME.err and NAME.code are what it must
# print and return (nothing and 0 where they are missing). Seconds are written as N, memory,
# errors, sun and exposure of frames are left out. --update writes them anew; --shard runs each N-th case from the I-th on.
set -u
update= shard=1 shards=1
case "${1:-}" in
--update)
  update=yes
  shift
  ;;
--shard)
  shard=${2%/*} shards=${2#*/}
  shift 2
  ;;
esac
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
shift
cases=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$program" "$work/bin/nephos"
PATH=$work/bin:$PATH
HOME=$work/home XDG_CACHE_HOME=$work/cache # no calibration of this machine
export PATH HOME XDG_CACHE_HOME
unset XDG_CONFIG_HOME XDG_DATA_HOME XDG_STATE_HOME XDG_RUNTIME_DIR TZ
mkdir "$work/home"
umask 077

# expect FILE ACTUAL: FILE, or nothing where there is none, equals ACTUAL; or becomes it.
expect() {
  if [ -n "$update" ]; then
    if [ -s "$2" ]; then cp "$2" "$1"; else rm -f "$1"; fi
    return 0
  fi
  [ -e "$1" ] || set -- /dev/null "$2"
  diff -u "$1" "$2"
}

failed=0 number=0
[ $# -gt 0 ] || set -- "$cases"/*.sh
for case in "$@"; do
  name=$(basename "$case" .sh)
  [ "$name" != run ] || continue
  number=$((number + 1))
  [ $((number % shards)) -eq $((shard % shards)) ] || continue
  if [ -n "${NEPHOS_SANITIZE:-}" ] && grep -q '^# .*Without sanitizers' "$cases/$name.sh"; then
    echo "skipped under sanitizers: $name"
    continue
  fi
  mkdir "$work/$name"
  (cd "$work/$name" && sh -eu "$cases/$name.sh" >"$work/out" 2>"$work/err" </dev/null)
  code=$?
  sed -i -E 's/^(volumes .*) [0-9.]+ s, [0-9.]+ [MG]B$/\1 N s/; s/^(frame .*) [0-9.]+ s, [0-9.]+ [MG]B(; .*)?$/\1 N s/; s/[0-9.]+ s$/N s/; s/[0-9.]+ s on [0-9]+ threads?$/N s on N threads/; s/, "memory_bytes": .*\}$/}/; s/"seconds": [0-9.]+/"seconds": N/' "$work/out"
  if [ $code -ne 0 ]; then echo $code; fi >"$work/code"
  ok=yes
  expect "$cases/$name.out" "$work/out" || ok=
  expect "$cases/$name.err" "$work/err" || ok=
  expect "$cases/$name.code" "$work/code" || ok=
  if [ -z "$ok" ]; then
    echo "FAILED: $name"
    failed=$((failed + 1))
  fi
done
[ $failed -eq 0 ] || echo "$failed cases failed"
exit $((failed > 0))
