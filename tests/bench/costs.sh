#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Predicted time and memory of pictures against measured ones, and the constants of the model of cost.
#
#   sh costs.sh NEPHOS --seed HEX --count K [--scenes DIR] [--files DIR] [--folder OUT] [--fit TABLE] [--page FILE]
#               [--check]
#
# NEPHOS    the program
# --seed    hexadecimal digits that draw the scenes
# --count   number of drawn scenes
# --scenes  folder of further scenes, which no constant is fitted to
# --files   folder of .vdb files, each of which is rendered as one cloud, and no constant is fitted to
# --folder  folder of scenes and measurements, a temporary one by default; a picture that was measured is not rendered
#           again
# --fit     fits the constants of src/plan/cost_table.h, and writes that file
# --page    file of the page, docs/results/costs.md
# --check   fails unless nine of ten pictures of 1 s and more are within 2 in time and within 1.3 in memory
#
# Needs python3 with numpy and scipy.
set -eu
nephos=$1
shift
exec "${PYTHON:-/usr/bin/python3}" -B "$(dirname "$0")/costs" "$nephos" "$@"
