# SPDX-License-Identifier: Apache-2.0
# The man pages: all are there, and groff has no warning.
mkdir manual
nephos help --man -o manual
ls manual
show() { groff -man -Tutf8 -P-cbu -ww -rLL="$1" "$2"; }
for page in manual/*; do
  show 100n "$page" >page.txt
  grep -q '^DESCRIPTION$' page.txt
done
show 100n manual/nephos-compare.1
nephos help --man compare | cmp - manual/nephos-compare.1
# Text that is odd for roff comes out as it is: dashes, quotes, letters beyond ASCII.
show 200n manual/nephos-scene.5 | grep -e 'cloud1, …' -e "the sun's disk in"
