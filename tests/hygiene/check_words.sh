#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_words.sh SOURCE_DIR: the syntax of comments (docs/CONTRIBUTING.md, Names and words). A comment is a sentence or a
# noun phrase that names the thing: neither it nor a parameter in it begins with a preposition, and code is no person.
set -eu
cd "$1"
fail=0
# complain TEXT FINDINGS: nothing found, nothing said.
complain() {
  [ -n "$2" ] || return 0
  printf '%s:\n%s\n' "$1" "$2" >&2
  fail=1
}

# Lines of comments as FILE:LINE:TEXT, with "/* " before the first line of each. Texts in quotes are skipped.
print_comments() {
  find include cli src tests samples -type f \( -name '*.[ch]' -o -name '*.cpp' \) | LC_ALL=C sort | xargs awk '
    FNR == 1 {inside = 0}
    {
      line = $0
      if (!inside) gsub(/"(\\.|[^"\\])*"/, "\"\"", line)
      while (line != "") {
        if (!inside) {
          if (!(begin = index(line, "/*"))) break
          line = substr(line, begin)
          sub(/^\/\*+<?[ -]*/, "", line)
          inside = 1
          mark = "/* "
        } else mark = ""
        end = index(line, "*/")
        text = end ? substr(line, 1, end - 1) : line
        line = end ? substr(line, end + 2) : ""
        if (end) inside = 0
        if (!mark) sub(/^ *\*? */, "", text)
        print FILENAME ":" FNR ":" mark text
        gsub(/"(\\.|[^"\\])*"/, "\"\"", line)
      }
    }'
}

comments=$(print_comments)
preposition='(of|by|from|as|for|with|at|on|to)'
complain 'comments that begin with a preposition' \
  "$(echo "$comments" | grep -iE "^[^:]*:[0-9]+:/\* $preposition( |\$)" || true)"
complain 'parameters whose description begins with a preposition' \
  "$(echo "$comments" | grep -E "^[^:]*:[0-9]+:(/\* )?@(param [^ ]+|return) +$preposition " || true)"
complain 'comments in which code is a person, or things are made' \
  "$(echo "$comments" | grep -iwE 'who|whom|nobody|asks?|asked|tells?|told|wants?|made' || true)"
exit $fail
