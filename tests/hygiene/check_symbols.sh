#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_symbols.sh SOURCE_DIR COMPILER SHARED_LIBRARY STATIC_LIBRARY: the library exports what its headers declare, all of
# it and nothing else, and keeps no state of its own.
set -eu
source=$1 compiler=$2 shared=$3 static=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail=0

# Declarations one a line, of which those of functions have a name before their parenthesis, those of tables before a bracket.
# A pointer to a function is a type.
"$compiler" -E -P -D'__attribute__(x)=' -I "$source/include" "$source/include/nephos/nephos.h" | tr '\n' ' ' |
  tr ';{}' '\n\n\n' | sed -E 's/neph_[a-z0-9_]+ *\(\*//g' | grep -oE '\bneph_[a-z0-9_]+ *[([]' | tr -d ' ([' | sort -u >"$folder/declared"
grep -rhoE '^NEPH_API [^([]*[([]' "$source/include/nephos" | grep -oE 'neph_[a-z0-9_]+[([]$' | tr -d '([' | sort -u >"$folder/marked"
nm -D --defined-only "$shared" | awk '{print $3}' | sed 's/@.*//' | sort -u >"$folder/exported"

# report TEXT FILE FILE: what the first has and the second has not.
report() {
  extra=$(comm -23 "$folder/$2" "$folder/$3")
  [ -n "$extra" ] || return 0
  printf '%s:\n%s\n' "$1" "$extra" >&2
  fail=1
}
[ -s "$folder/declared" ] || { echo "no declaration was found in the headers" >&2; exit 1; }
report 'declared without NEPH_API' declared marked
report 'declared, but the library does not define it' declared exported
report 'exported, but no header declares it' exported declared
nm -D --defined-only "$shared" | awk '$2 == "T" {print $3}' | sed 's/@.*//' | sort -u >"$folder/functions"
grep -oE '\bneph_[a-z0-9_]+\b' "$source/tests/test_null_arguments.c" | sort -u >"$folder/called"
report 'functions that tests/test_null_arguments.c does not call with NULL' functions called

# Constant tables with addresses lie in .data.rel.ro and are fine. nova_lock guards the state that libnova has.
state=$(objdump -t "$static" |
  awk '/file format/ {file = $1} $3 == "O" && $4 ~ /^\.t?(data|bss)(\.[^r].*)?$/ {print file " " $NF}' |
  grep -vx 'celestial.c.o: nova_lock' || true)
if [ -n "$state" ]; then
  printf 'variables outside of any context:\n%s\n' "$state" >&2
  fail=1
fi
exit $fail
