#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Writes docs/stability.md by the tests of stability, each of which has a section.
# Usage: tests/bench/stability.sh [BIN], the folder of test programs, build/release/bin by default
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=${1:-$root/build/release/bin}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/page" <<'END'
# Stability

Stiff and extreme inputs: how many were tried, the worst error of each kind, and what is refused with which message. The
tests `stress`, `stiffness`, `deep_clouds`, `extreme_air` and `climb` hold these limits and write this page:

    sh tests/bench/stability.sh

Counts and refusals are the same on any machine, and the tests fail where this page has others. Methods are in
[transport.md](transport.md) and [atmosphere.md](atmosphere.md), errors of ordinary scenes in
[accuracy.md](accuracy.md).
END
for part in stress stiffness deep_clouds extreme_air climb; do
  [ -x "$bin/test_$part" ] || continue
  "$bin/test_$part" page "$folder/$part" >/dev/null
  cat "$folder/$part" >>"$folder/page"
done
mv "$folder/page" "$root/docs/stability.md"
