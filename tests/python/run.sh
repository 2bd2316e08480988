#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# run.sh BUILD_DIR SOURCE_DIR: the tests of the Python package of a build, by pytest and numpy of the system.
set -eu
build=$1 source=$2
python=${NEPHOS_TEST_PYTHON:-/usr/bin/python3}
"$python" -c 'import numpy, pytest' 2>/dev/null || {
  [ -z "${NEPHOS_REQUIRE_TOOLS:-}" ] || { echo "python3-numpy and python3-pytest are required here"; exit 1; }
  exit 77
}
export PYTHONPATH="$build/python" NEPHOS_LIBRARY="$build/lib/libnephos.so" NEPHOS_PROGRAM="$build/bin/nephos"
export NEPHOS_INCLUDE="$source/include" PYTHONDONTWRITEBYTECODE=1
shift 2
exec "$python" -m pytest -q -p no:cacheprovider --durations=5 "$@" "$source/tests/python"
