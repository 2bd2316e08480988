# SPDX-License-Identifier: Apache-2.0
try() { if nephos info "$1" 2>/dev/null; then exit 99; else [ $? -eq 5 ]; fi; }
for name in a.vdb a.hgt a.exr a.png; do
  echo 'this is no such file' >$name
  try $name
done
