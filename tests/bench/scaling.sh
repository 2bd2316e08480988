#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Speed-up of a run with the number of threads, computed from a run on one thread: prints the tables of
# docs/results/scaling.md.
#
#   sh scaling.sh NEPHOS VERB FILE [ARGUMENT…]
#
# NEPHOS    the program
# VERB      render or bake
# FILE      the scene; the output is a temporary file
# ARGUMENT  further arguments of the verb
#
# The CPU time of each piece of each parallel loop is measured at one thread. A schedule of the same pieces on n threads
# is simulated, as the pool hands them out, with a latency for each loop: 10 us at 2 threads, 15 at 4, 25 at 8, 50 at
# 16, 150 at 64. What the calling thread does between loops is serial. Real runs at one and two threads stand beside
# their simulation. RUNS=N sets their number (default 3, of which the fastest counts; 0: none).
set -eu
exec "${PYTHON:-python3}" -B "$(dirname "$0")/scaling" "$@"
