# SPDX-License-Identifier: Apache-2.0
# The I3RC by path and by march: prints docs/results/i3rc.md.
#
#   sh i3rc.sh NEPHOS CASE1 CASE3 OUT
#
# NEPHOS   the program
# CASE1    folder with the consensus results of case 1
# CASE3    folder with the inputs and the consensus results of case 3
# OUT      existing folder for the answers path.csv and march.csv, which are kept: those that are there are used
set -eu
nephos=$1 first=$2 third=$3 out=$4
# answer NAME ERROR1 PATHS1 ERROR3 PATHS3 [OPTION…]: both cases in one table
answer() {
  name=$1 error_1=$2 paths_1=$3 error_3=$4 paths_3=$5
  shift 5
  [ ! -f "$out/$name.csv" ] || return 0
  "$nephos" probe i3rc "$first" "$@" --target-error "$error_1" --paths "$paths_1" -q >"$out/$name.part"
  "$nephos" probe i3rc "$third" "$@" --target-error "$error_3" --paths "$paths_3" -q | sed 1d >>"$out/$name.part"
  mv "$out/$name.part" "$out/$name.csv"
}
answer path 0.002 1500000 0.003 2000000
answer march 0.003 200000 0.003 200000 --integrator march
exec /usr/bin/python3 "$(dirname "$0")/i3rc_page.py" "$out/path.csv" "$out/march.csv"
