# SPDX-License-Identifier: Apache-2.0
echo 'version: 1' | nephos bake -
