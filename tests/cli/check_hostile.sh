# SPDX-License-Identifier: Apache-2.0
# Files made to do harm are checked with one line at least, within 5 s of a processor and 256 MB besides the 300 MB of
# addresses that the program and its libraries have. Without sanitizers, which take terabytes of addresses.
data=$(dirname "$0")/../data
for file in "$data"/hostile/*.vdb "$data"/vdb/*.vdb; do
  code=0
  (ulimit -t 5 && ulimit -v 556000 && nephos check "$file" -t 1 >out 2>err) || code=$?
  echo "exit $code: $(basename "$file"), $(tail -n 1 out)"
  cat err
done
