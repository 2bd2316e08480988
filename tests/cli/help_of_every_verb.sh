# SPDX-License-Identifier: Apache-2.0
for verb in $(nephos --help | sed -n '/^verbs:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do nephos $verb -h; done
