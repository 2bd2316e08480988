# SPDX-License-Identifier: Apache-2.0
# The I3RC by path and by march: prints docs/results/i3rc.md.
#
#   sh i3rc.sh NEPHOS FOLDER OUT
#
# NEPHOS   the program
# FOLDER   inputs and consensus results of cases 1 and 3
# OUT      existing folder for the answers path.csv and march.csv, which are kept: those that are there are used
set -eu
nephos=$1 folder=$2 out=$3
[ -f "$out/path.csv" ] || "$nephos" probe i3rc "$folder" --target-error 0.003 --paths 2000000 -q -o "$out/path.csv"
[ -f "$out/march.csv" ] ||
  "$nephos" probe i3rc "$folder" --integrator march --target-error 0.003 --paths 200000 -q -o "$out/march.csv"
exec /usr/bin/python3 "$(dirname "$0")/i3rc_page.py" "$out/path.csv" "$out/march.csv"
