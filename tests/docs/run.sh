#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the examples of documents: run.sh PROGRAM PAGE.md…
# In a page's fenced blocks, ```yaml NAME, ```csv NAME and ```python NAME are the file NAME, and ```console is a session: lines that
# begin with "$ " are commands, the lines behind one are what it prints on both outputs. A line "..." stands for whatever
# follows; seconds, memory and errors of frames are not compared, sun and exposure where a page shows them. All of a page
# runs in one empty folder, with `nephos` in the path, and `python3` that has numpy.
set -u
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin"
ln -s "$program" "$work/bin/nephos"
ln -s "${NEPHOS_TEST_PYTHON:-/usr/bin/python3}" "$work/bin/python3"
PATH=$work/bin:$PATH
HOME=$work/home XDG_CACHE_HOME=$work/cache # no calibration of this machine
export PATH HOME XDG_CACHE_HOME
unset XDG_CONFIG_HOME XDG_DATA_HOME XDG_STATE_HOME XDG_RUNTIME_DIR TZ
mkdir "$work/home"
umask 077

# Splits a page into steps: NNN.file with NNN.name, or NNN.command with NNN.expected.
split_page() {
  awk -v steps="$2" '
    function begin() { step = sprintf("%s/%03d", steps, ++count) }
    /^```/ && inside { inside = ""; next }
    /^```(yaml|csv|python) [^ ]+$/ { inside = "file"; begin(); print $2 > (step ".name"); printf "" > (step ".file"); next }
    /^```console$/ { inside = "console"; next }
    /^```/ { inside = "other"; next }
    inside == "file" { print > (step ".file") }
    inside == "console" && /^\$ / { begin(); print substr($0, 3) > (step ".command"); printf "" > (step ".expected"); next }
    inside == "console" { print > (step ".expected") }
  ' "$1"
}

without_times() { sed -E 's/^(frame .*) [0-9.]+ s, [0-9.]+ [MG]B(; error[^;]*)?(; .*)?$/\1 N s\3/; s/[0-9.]+ s\b/N s/g; s/, "memory_bytes": .*\}$/}/; s/"seconds": [0-9.]+/"seconds": N/'; }

# Compares two files up to a last line "..." of the first.
matches() {
  if [ "$(tail -n 1 "$1")" = ... ]; then
    count=$(($(wc -l <"$1") - 1))
    head -n $count "$1" >"$1.head"
    head -n $count "$2" >"$2.head"
    set -- "$1.head" "$2.head"
  fi
  without_times <"$1" >"$1.plain"
  without_times <"$2" >"$2.plain"
  grep -q '; sun at' "$1" || sed -i 's/^\(frame .* N s\); .*/\1/' "$1.plain" "$2.plain"
  diff -u "$1.plain" "$2.plain"
}

run_step() {
  if [ -e "$1.name" ]; then
    cp "$1.file" "$(cat "$1.name")"
    return 0
  fi
  sh -c "$(cat "$1.command")" >"$1.actual" 2>&1 </dev/null
  matches "$1.expected" "$1.actual" && return 0
  echo "FAILED: \$ $(cat "$1.command")"
  return 1
}

failed=0
for page in "$@"; do
  name=$(basename "$page" .md)
  mkdir "$work/$name" "$work/$name.steps"
  split_page "$page" "$work/$name.steps"
  ran=0
  for step in $(find "$work/$name.steps" -name '*.name' -o -name '*.command' | sed 's/\.[a-z]*$//' | sort); do
    (cd "$work/$name" && run_step "$step") || failed=$((failed + 1))
    ran=$((ran + 1))
  done
  echo "$page: $ran steps"
  [ $ran -gt 0 ] || failed=$((failed + 1))
done
exit $((failed > 0))
