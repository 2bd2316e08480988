# SPDX-License-Identifier: Apache-2.0
# Each of these is refused.
try() { if nephos render scene.yaml "$@"; then exit 99; else [ $? -eq 2 ]; fi; }
try --threads 0
try -t many
try --isa sse2
try --frames 5-1
try --frames 1-
try --frames 1,,2
try --frames 99999999999
try --resolution 960
try --crop 1,2,3
try --tile 0/4
try --tile 5/4
try --progress loud
try --set camera.fov
try --set =3
nephos sky scene.yaml --frames 3 || echo "exit $?" >&2
nephos render scene.yaml --sampels=3 || echo "exit $?" >&2
nephos render scene.yaml --path-maping=x || echo "exit $?" >&2
nephos render scene.yaml --xyzzy || echo "exit $?" >&2
try --frames 1-2147483647
try --frames 1-100000,200000
try --threads 1025
try -o ''
try --cache ''
try --cache=
nephos '' || echo "exit $?" >&2
