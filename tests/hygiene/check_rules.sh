#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Each rule of a check, a row of a table in src/check or of places, is on the page of rules, and each of the page is broken by a test,
# which names it. Usage: check_rules.sh SOURCE_DIR
set -u
cd "$1" || exit 2

status=0
quoted='"[a-z]*\.[a-z_]*"\|"openvdb"\|"read"'
rows=$(grep -hoE '\{"[a-z]+(\.[a-z_]+)?", (NEPH_SEVERITY|is_)' src/check/*.c src/plan/placement.c | grep -o "$quoted" | tr -d '"' | sort -u)
page=$(sed -n 's/^| \(`[^|]*`\) |.*/\1/p' docs/check.md | tr ',' '\n' | tr -d '` ' | sort -u)
[ "$(echo "$rows" | wc -l)" -ge 40 ] || { echo "fewer than 40 rules are found in src/check"; status=1; }
for rule in $rows; do
  echo "$page" | grep -qx "$rule" || grep -q "\`$rule\`" docs/check.md || { echo "docs/check.md lacks $rule"; status=1; }
done
for rule in $rows $page; do
  grep -q "\"$rule\"" tests/test_check*.c || grep -q "[[\"]$rule[]\"]" tests/cli/check*.out || {
    echo "no test breaks the rule $rule"
    status=1
  }
done
exit $status
