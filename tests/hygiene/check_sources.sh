#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_sources.sh SOURCE_DIR: names, licence lines, lengths, and what this code does without (docs/CONTRIBUTING.md).
set -eu
cd "$1"
fail=0
# complain TEXT FINDINGS: nothing found, nothing said.
complain() {
  [ -n "$2" ] || return 0
  printf '%s:\n%s\n' "$1" "$2" >&2
  fail=1
}

folders=
for folder in include src cli tests samples cmake .ci; do [ ! -d $folder ] || folders="$folders $folder"; done
sources=$(find $folders -type f \( -name '*.[ch]' -o -name '*.cpp' \) -not -path 'samples/out/*' | sort)
scripts=$(find $folders -type f \( -name '*.sh' -o -name '*.cmake' -o -name CMakeLists.txt -o -name '*.yaml' -o -path .ci/run \) \
  -not -path 'samples/out/*' -not -path 'tests/data/*' | sort)

complain 'two files of one name' "$(echo "$sources" | grep -E '^(src|cli)/.*\.(c|cpp)$' | sed 's|.*/||; s|\.[^.]*$||' | sort | uniq -d)"
complain 'names that say nothing' "$(echo "$sources" | grep -E '/(util|utils|common|misc|helpers?)\.' || true)"
complain 'names with a verb that says nothing' "$(grep -nowE '([a-z]+_)*find(_[a-z0-9_]+)?\(' $sources || true)"
complain 'no SPDX line first' "$(for file in $sources; do
  head -n 1 "$file" | grep -qx '/\* SPDX-License-Identifier: Apache-2.0 \*/' || echo "$file"
done)"
complain 'no SPDX line among the first two' "$(for file in $scripts; do
  head -n 2 "$file" | grep -q '^# SPDX-License-Identifier: Apache-2.0$' || echo "$file"
done)"
complain 'more than 800 lines' "$(wc -l $sources | awk '$1 > 800 && $2 != "total" {print $2 ": " $1}')"
complain 'more than 120 columns' "$(LC_ALL=C.UTF-8 grep -nE '^.{121}' $sources | cut -c 1-100 || true)"
complain 'tabs or blanks at the end' "$(grep -nE "$(printf '\t')| \$" $sources || true)"
complain 'comments of the other kind' "$(grep -nE '^([^"]*[ ;{}])?//' $sources || true)"
complain 'comments that do not begin with what they are about' \
  "$(grep -nE '/\*+<? ?(What|How much|How|That which|Of|Where|To) ' $sources || true)"
complain 'marks of an unfinished merge' "$(grep -nE '^(<<<<<<<|>>>>>>>) ' $sources $scripts || true)"
complain 'notes of unfinished work' "$(grep -nwE 'TODO|FIXME|XXX' $sources || true)"
complain 'f() for f(void)' "$(grep -nE '^[a-z][a-z0-9_ *]*[a-z0-9_]+\(\) *[{;]' $(echo "$sources" | grep -v '\.cpp$') || true)"
complain 'results of snprintf that are ignored: np_print, np_text_add, or cli_print and cli_text_add of the program' \
  "$(grep -nE '(^|[;{)]|else|\(void\)|\(size_t\)) *(std::)?v?snprintf\(' $(echo "$sources" | grep -E '^(src|cli)/') |
    grep -vE '(if|while) \(v?snprintf' || true)"
complain 'environment variables in the library' "$(grep -rnwE 'getenv|secure_getenv' include src || true)"
complain 'types that end in _t' "$(grep -rnE '^\} *np?e?p?h?_[a-z0-9_]+_t;' include src || true)"
exit $fail
