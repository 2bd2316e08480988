# SPDX-License-Identifier: Apache-2.0
echo 'version: 1' | nephos render - --explain --json --crop 0,0,10,20
