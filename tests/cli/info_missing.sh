# SPDX-License-Identifier: Apache-2.0
try() { if nephos info "$1" 2>/dev/null; then exit 99; else [ $? -eq 4 ]; fi; }
try none.vdb
try none.hgt
try none.exr
try none.png
try none.yaml
