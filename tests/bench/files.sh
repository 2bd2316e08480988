# SPDX-License-Identifier: Apache-2.0
# Real files and what `info` and `check` say of them, and the cost of loading them: the tables of docs/results/files.md.
#
#   sh files.sh BIN FOLDER
#
# BIN      folder of nephos, bench_files and bench_terrain_files
# FOLDER   files, in any depth
set -eu
export LC_ALL=C
bin=$(cd "$1" && pwd)
cd "$2"

# Grids with their type, voxels and size; or the samples of a height field.
describe() {
  "$bin/nephos" info "$1" 2>/dev/null | awk '
    /^grid / { name = $2; sub(/^[^\x27]*\x27/, "", $0); sub(/\x27$/, "", $0); name = $0 }
    /^  class / { class = substr($0, 17) }
    /^  type / { type = $2; sub(/,/, "", type) }
    /^  active / { text = text sep name " (" type ", " class ", " ($2 == "nothing" ? "empty" : $2 " voxels") ")"; sep = "; " }
    /^samples / { text = $2 " × " $4 " samples" }
    /^elevation / { text = text ", " $2 " to " $4 " " $5 }
    END { print text == "" ? "refused" : text }'
}

# Rules of errors and warnings, with their number, then that of the notes.
check() {
  { "$bin/nephos" check "$1" 2>/dev/null || true; } | awk '
    / \[[a-z_.]*\]$/ {
      rule = $NF; gsub(/[][]/, "", rule)
      rest = substr($0, index($0, ": ") + 2)
      severity = rest; sub(/:.*/, "", severity)
      if (severity == "note") notes++
      else if (!(rule in count)) { order[++rules] = rule; kind[rule] = severity }
      if (severity != "note") count[rule]++
      if (severity == "error" && rule == "read") { cause = rest; sub(/^error: /, "", cause); sub(/ \[read\]$/, "", cause) }
    }
    END {
      for (i = 1; i <= rules; i++) {
        rule = order[i]
        text = text sep kind[rule] " `" rule "`" (count[rule] > 1 ? " ×" count[rule] : "")
        sep = ", "
      }
      if (notes) text = text sep notes " note" (notes > 1 ? "s" : "")
      if (cause != "") text = text ": " cause
      print text == "" ? "nothing" : text
    }'
}

files=$(find . -type f \( -name '*.vdb' -o -name '*.hgt' -o -name '*.tif' \) | sed 's#^\./##' | sort)
echo '## Contents'
echo
echo '| file | info | check |'
echo '| --- | --- | --- |'
for file in $files; do echo "| $(basename "$file") | $(describe "$file") | $(check "$file") |"; done
echo
echo '## Loading clouds'
echo
# OpenVDB, unchecked, warns of damaged grids on standard output.
"$bin/bench_files" $(echo "$files" | grep 'vdb$') | sed 's/\x1b\[[0-9;]*m//g; / WARN: /d'
echo
echo '## Loading height fields'
echo
"$bin/bench_terrain_files" $(echo "$files" | grep -v 'vdb$') | sed 's#^| [^ ]*/#| #'
