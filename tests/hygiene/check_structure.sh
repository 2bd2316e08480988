#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_structure.sh SOURCE_DIR: no type name defined twice, no function above 80 lines.
set -eu
cd "$1"
fail=0
# complain TEXT FINDINGS: nothing found, nothing said.
complain() {
  [ -n "$2" ] || return 0
  printf '%s:\n%s\n' "$1" "$2" >&2
  fail=1
}
sources=$(find include src cli samples -type f \( -name '*.[ch]' -o -name '*.cpp' \) | sort)

complain 'a type name defined twice' "$(grep -hoE '^(typedef )?(struct|enum|union) [a-z_0-9]+ \{' $sources |
  awk '{print $(NF - 1)}' | sort | uniq -d)"

# A function starts with its name's line at the margin and ends with a brace there.
complain 'a function above 80 lines' "$(awk '
  FNR == 1 || /^}/ {
    if (start && FNR - start + 1 > 80) print FILENAME ":" start ": " FNR - start + 1 " lines: " name
    start = 0
  }
  !start && /^[A-Za-z_].*\(/ && !/[;=]/ && !/^(typedef|enum|struct|#)/ {start = FNR; name = $0}
  start && !/\{$/ && /;$/ && /^ {4,}|^[A-Za-z_]/ && !body[FILENAME, start] {start = 0}
  start && /\{$/ {body[FILENAME, start] = 1}
' $sources)"
exit $fail
