#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs every test but those labelled "long".
# Tests on real files look for them in $NEPHOS_TEST_DATA, else in ../shared/data, and are skipped without.
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing_packages

data=${NEPHOS_TEST_DATA:-}
if [ -z "$data" ] && [ -d ../shared/data ]; then data=$(cd ../shared/data && pwd); fi

cmake --preset release -DNEPHOS_TEST_DATA="$data"
cmake --build --preset release
# Tools that this script installs are there: their tests are never skipped.
if command -v apt-get >/dev/null; then export NEPHOS_REQUIRE_TOOLS=1; fi
# Nothing of this machine or its user passes or fails a test: folders of their own are empty (CMakePresets.json, "bare").
rm -rf build/release/bare
mkdir -p build/release/bare/home build/release/bare/tmp
umask 077
exec ctest --preset release --label-exclude long --parallel 2
