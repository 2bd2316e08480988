#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Latency of `nephos view`: prints the table of docs/results/view.md.
#
#   sh view.sh NEPHOS [CLOUD.vdb]
#
# NEPHOS     the program, beside its tests
# CLOUD.vdb  wdas_cloud_sixteenth.vdb, for the lines of a file
set -eu
exec /usr/bin/python3 -B "$(dirname "$0")/view.py" "$@"
