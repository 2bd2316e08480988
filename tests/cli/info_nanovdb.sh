# SPDX-License-Identifier: Apache-2.0
# A file of NanoVDB is told how to convert, whoever reads it.
printf 'NanoVDB0' >cloud.nvdb
try() {
  code=0
  nephos "$@" || code=$?
  echo "exit $code"
}
try info cloud.nvdb
try check cloud.nvdb
