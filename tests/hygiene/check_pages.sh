#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_pages.sh SOURCE_DIR: README.md and docs/. Links and anchors resolve, README's map lists every page, each table of
# results follows a command that exists, headings name a thing, and words are those of the field.
set -eu
cd "$1"
fail=0
# complain TEXT FINDINGS: nothing found, nothing said.
complain() {
  [ -n "$2" ] || return 0
  printf '%s:\n%s\n' "$1" "$2" >&2
  fail=1
}

pages=$(find README.md docs -name '*.md' | LC_ALL=C sort)
results=$(find docs/results -name '*.md' | LC_ALL=C sort)

# Text of a page outside its fenced blocks, as PAGE:LINE:TEXT.
print_prose() { awk 'FNR == 1 {inside = 0} /^```/ {inside = !inside; next} !inside {print FILENAME ":" FNR ":" $0}' "$@"; }

# Anchors of a page: its headings in lower case, without punctuation, blanks as hyphens.
list_anchors() {
  sed '/^```/,/^```/d' "$1" | sed -n 's/^##* *//p' | tr 'A-Z ' 'a-z-' | LC_ALL=C sed 's/[^a-z0-9_-]//g'
}

check_links() {
  for page in $pages; do
    print_prose "$page" | sed 's/`[^`]*`//g' | grep -oE '\]\([^)]+\)' | sed 's/^](//; s/)$//' | sort -u |
      while IFS= read -r link; do
        case $link in http://* | https://* | mailto:*) continue ;; esac
        file=${link%%#*} anchor=
        case $link in *'#'*) anchor=${link#*'#'} ;; esac
        target=$page
        [ -z "$file" ] || target=$(dirname "$page")/$file
        if [ ! -e "$target" ]; then
          echo "$page: $link"
        elif [ -n "$anchor" ] && ! list_anchors "$target" | grep -Fxq -- "$anchor"; then
          echo "$page: $link (no such heading)"
        fi
      done
  done
}

# Tables of results before which their section has neither a command nor the words that none is left.
list_tables_without_command() {
  awk '
    FNR == 1 || /^#/ {has_command = 0}
    /^    [^ ]/ || /[Nn]o command remains/ {has_command = 1}
    /^\|/ && !in_table && !has_command {print FILENAME ":" FNR ": " substr($0, 1, 60)}
    {in_table = /^\|/}
  ' $results
}

# Commands of results, one to a line, as PAGE COMMAND.
list_commands() {
  awk '
    FNR == 1 {inside = goes_on = 0}
    /^```/ {inside = !inside}
    inside || !/^    [^ ]/ {goes_on = 0; next}
    {was = goes_on; goes_on = /\\$/}
    was || /^    [0-9]/ {next}
    {sub(/^ +/, ""); count = split($0, parts, /; */); for (i = 1; i <= count; i++) print FILENAME, parts[i]}
  ' $results docs/accuracy.md docs/benchmarks.md
}

check_commands() {
  list_commands | while read -r page first second rest; do
    while [ "$first" = /usr/bin/time ] || [ "$first" = -v ] || [ "$first" = valgrind ] || [ "$first" = --tool=callgrind ]; do
      first=$second second=${rest%% *} rest=${rest#* }
    done
    case $first in
    nephos) [ -f "cli/command_$second.c" ] || grep -rqs "\"$second\"" cli || echo "$page: nephos $second" ;;
    bench_*) [ -f "tests/bench/$first.c" ] || echo "$page: $first" ;;
    test_*)
      [ -f "tests/$first.c" ] || echo "$page: $first"
      [ "$second" != long ] || grep -qs '"long"' "tests/$first.c" || echo "$page: $first long"
      ;;
    sh) [ -f "$second" ] || echo "$page: sh $second" ;;
    cmake | ctest) ;;
    *) echo "$page: $first is not a command of the project" ;;
    esac
  done
}

# Files of the tree that pages name in backquotes. Recipes of docs/CONTRIBUTING.md name files that are to be written.
list_missing_files() {
  for page in $pages; do
    [ "$page" != docs/CONTRIBUTING.md ] || continue
    print_prose "$page" | grep -oE '`(src|include|cli|tests|samples|cmake|docs)/[A-Za-z0-9_/.-]+\.[a-z]+`' | tr -d '`' | sort -u |
      while read -r file; do [ -e "$file" ] || echo "$page: $file"; done
  done
}

# Words that docs/CONTRIBUTING.md replaces by those of the field.
private_words="artist's lights?|sun depths?|depths? towards the sun|[Tt]hrown?|hands? down|handed down|outlook|sunward"
private_words="$private_words|[Tt]he truth|truth's|scattered more than once|[Ww]hat glows|inflow|spared?|baked anew|built anew"

complain 'fences that do not close' "$(for page in $pages; do
  [ $(($(grep -c '^```' "$page" || true) % 2)) -eq 0 ] || echo "$page"
done)"
complain 'links that lead nowhere' "$(check_links)"
complain 'pages that README.md does not list' "$(for page in $pages; do
  [ "$page" = README.md ] || grep -Fq "($page)" README.md || echo "$page"
done)"
complain 'tables of results without their command' "$(list_tables_without_command)"
complain 'commands that do not exist' "$(check_commands)"
complain 'files that do not exist' "$(list_missing_files)"
complain 'headings that name nothing' "$(print_prose $pages | grep -E ':#+ (What|How much|How many|Of|Where|That which) ' || true)"
complain 'private words' "$(print_prose $pages | grep -v '^docs/CONTRIBUTING.md:[0-9]*:|' | grep -wE "$private_words" || true)"
complain 'more than 120 columns' "$(print_prose $pages | LC_ALL=C.UTF-8 grep -E '^[^:]*:[0-9]+:[^ |!].{120}' | cut -c 1-100 || true)"
exit $fail
