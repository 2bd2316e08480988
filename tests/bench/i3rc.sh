# SPDX-License-Identifier: Apache-2.0
# The I3RC by path and by march: prints docs/results/i3rc.md.
#
#   sh i3rc.sh NEPHOS CASE1 CASE3 OUT
#
# NEPHOS   the program
# CASE1    folder with the consensus results of case 1
# CASE3    folder with the inputs and the consensus results of case 3
# OUT      existing folder for the answers path.csv, fewer.csv and march.csv, which are kept: those that are there are used
set -eu
nephos=$1 first=$2 third=$3 out=$4
# probe DIR ERROR PATHS [OPTION…]
probe() {
  folder=$1 error=$2 paths=$3
  shift 3
  "$nephos" probe i3rc "$folder" --target-error "$error" --paths "$paths" -q "$@"
}
# answer NAME COMMAND: its output as OUT/NAME.csv
answer() {
  [ -f "$out/$1.csv" ] || { "$2" >"$out/$1.part" && mv "$out/$1.part" "$out/$1.csv"; }
}
# both COMMAND1 COMMAND2: one table of two
both() { "$1" && rows=$("$2") && printf '%s\n' "$rows" | sed 1d; }
trace_first() { probe "$first" 0.002 1500000; }
trace_third() { probe "$third" 0.003 2000000; }
march_first() { probe "$first" 0.003 200000 --integrator march; }
march_third() { probe "$third" 0.003 200000 --integrator march; }
trace() { both trace_first trace_third; }
march() { both march_first march_third; }
trace_fewer() { probe "$first" 0.003 2000000; }
answer path trace
answer fewer trace_fewer
answer march march
exec /usr/bin/python3 "$(dirname "$0")/i3rc_page.py" "$out/path.csv" "$out/fewer.csv" "$out/march.csv"
