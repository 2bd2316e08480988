#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Starts the jobs of each farm for scenes and options with names that try to become commands: hostile.sh PROGRAM
# Stubs stand for Slurm and for a host of OpenCue, PyYAML reads the templates, and GNU parallel is itself where it is
# installed. Each task gets the arguments that were given.
set -eu
python=/usr/bin/python3 # the one that Debian's packages are for
if ! $python -c 'import yaml' 2>/dev/null; then
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "python3-yaml is required here"; exit 1; }
  echo "skipped: python3-yaml is not installed"
  exit 77
fi
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
exec $python "$(cd "$(dirname "$0")" && pwd)/hostile.py" "$program"
