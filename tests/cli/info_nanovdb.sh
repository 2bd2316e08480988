# SPDX-License-Identifier: Apache-2.0
# Files of NanoVDB are described and checked as .vdb files are; what is none, or of a version that is not read, is refused.
data=$(dirname "$0")/../data/nvdb
try() {
  code=0
  nephos "$@" || code=$?
  echo "exit $code"
}
for name in zip blosc zip_fpn; do
  cp "$data/$name.nvdb" .
  try info $name.nvdb
done
try check zip.nvdb
printf 'NanoVDB0' >short.nvdb
try info short.nvdb
try check short.nvdb
cp zip.nvdb older.nvdb
printf '\240\003' | dd of=older.nvdb bs=1 seek=10 conv=notrunc 2>/dev/null
try info older.nvdb
printf '0BDVonaN' | dd of=zip.nvdb bs=1 conv=notrunc 2>/dev/null
try info zip.nvdb
try check blosc.nvdb --fix -o fixed.vdb
