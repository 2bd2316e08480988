# SPDX-License-Identifier: Apache-2.0
# Bytes go by constants that are fitted.
echo 'version: 1' | nephos render - --explain --json --crop 0,0,10,20 |
  sed 's/"bytes": [0-9.e+]*/"bytes": B/'
