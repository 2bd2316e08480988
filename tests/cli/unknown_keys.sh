# SPDX-License-Identifier: Apache-2.0
# Thousands of unknown keys take a time in proportion to their number: 0.3 s here, of the 8 s that they are given.
{ echo 'version: 1'; seq 20000 | sed 's/.*/k&: 1/'; } >keys.yaml
(ulimit -t 8; nephos info keys.yaml) || echo "exit $?"
