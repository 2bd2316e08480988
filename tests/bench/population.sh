#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The march against the path tracer in scenes that are drawn and not chosen: prints docs/results/population.md.
#
#   sh population.sh NEPHOS --seed N --count K [--folder DIR] [--limit SECONDS] [--page FILE] [--scenes N,N…]
#                    [--resolution WxH] [--worst SHARE] [--shared] [--machine FILE] [--jobs N]
#
# NEPHOS        the program
# --seed        hexadecimal digits: the first eight of the commit that is measured
# --count       scenes
# --folder      for scenes and pictures, a temporary one by default; a picture that is there is not rendered again
# --limit       CPU seconds of a scene's reference; default 300
# --page        file of the page; default standard output
# --scenes      numbers of the draw, 0 the first, in place of the first K that show clouds
# --resolution  of the pictures; default 64x36
# --machine     file of this machine's factors on predicted seconds (nephos report --calibrate), measured if it is not
#               there; without it the built-in costs are compared
# --jobs        scenes at once, each on one thread; default: all threads of the machine
# --shared      pictures of a scene share bakes, tables and light by a cache: the same bits in less time, and seconds that
#               leave out what was there
# --worst       the command fails where a resolved region errs by more than this share
#
# Needs python3 with numpy and scipy.
set -eu
nephos=$1
shift
exec "${PYTHON:-/usr/bin/python3}" -B "$(dirname "$0")/population" "$nephos" "$@"
