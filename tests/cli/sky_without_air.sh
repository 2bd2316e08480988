# SPDX-License-Identifier: Apache-2.0
echo 'atmosphere: none' | nephos sky - -q
