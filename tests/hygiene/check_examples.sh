#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check_examples.sh SOURCE_DIR: each verb of the program, preset of clouds and AOV has the files and the lines of pages
# that its recipe in docs/CONTRIBUTING.md names. Tests hold the examples of the other tables to their rows.
set -eu
cd "$1"
fail=0
complain() { echo "$1" >&2; fail=1; }

verbs=$(sed -n '/^#define CLI_VERBS/,/^$/p' cli/verbs.h | grep -oE 'ROW\([a-z]+\)' | sed 's/ROW(\(.*\))/\1/')
presets=$(sed -n '/^static const preset presets/,/^};/p' src/cloud/presets.c | sed -n 's/^    {"\([a-z_]*\)".*/\1/p')
aovs=$(sed -n 's/^  ROW([A-Z_]*, "\([a-z_]*\)".*/\1/p' src/image/aov.h)
[ -n "$verbs" ] && [ -n "$presets" ] && [ -n "$aovs" ] || complain 'a table is not found where it was'

for verb in $verbs; do
  grep -q "command_$verb\.c" cli/CMakeLists.txt || complain "the verb $verb: add command_$verb.c to cli/CMakeLists.txt"
  cases=$(ls tests/cli/"$verb".sh tests/cli/"$verb"_*.sh 2>/dev/null || true)
  [ -n "$cases" ] && grep -qw "$verb" $cases ||
    complain "the verb $verb has no case: add tests/cli/${verb}_….sh, which runs it, with .out, .err and .code"
  grep -q "^## $verb$" docs/cli.md || complain "the verb $verb has no section: add '## $verb' to docs/cli.md"
done
for preset in $presets; do
  grep -q "\`$preset\`" docs/cloud-parameters.md ||
    complain "the preset $preset is on no page: add a line to docs/cloud-parameters.md#presets"
  grep -q "^$preset " samples/presets.sh || complain "the preset $preset has no view: add a line to samples/presets.sh"
done
for aov in $aovs; do
  grep -qE "\`$aov[.\` ]" docs/scene-format.md ||
    complain "the AOV $aov is on no page: add a line to docs/scene-format.md#channels"
done
exit $fail
