# SPDX-License-Identifier: Apache-2.0
# A disk that fills in the middle of a batch stops it: finished frames stay, nothing half-written does, and after room is
# made the same command goes on to the bits of a batch that nothing stopped. The disk is of memory where one may be
# mounted, and else a limit on the size of files. Two processes that write the same frames leave them whole.
cat >scene.yaml <<'YAML'
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], fov: 50 deg, resolution: [64, 36]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 33}}
render: {samples: 16, seed: 3}
output: {image: "disk/a.####.exr", pixel_type: float}
YAML
mkdir disk
nephos render scene.yaml -q --frames 1-3 -o "whole.####.exr" >/dev/null
pages=$((($(wc -c <whole.0001.exr) + 4095) / 4096))
cat >run.sh <<'END'
batch() { nephos render scene.yaml -q --frames 1-3 --checkpoint 0.01s --resume --skip-existing "$@"; }
check() { for frame in 1 2 3; do nephos compare disk/a.000$frame.exr whole.000$frame.exr --exact | head -n 1; done; }
END
cat >fill.sh <<'END'
. ./run.sh
# A page too few for three pictures.
mount -t tmpfs -o size=$(((3 * $1 - 1) * 4))k tmpfs disk
batch 2>errors | sed 's/, .*//'
grep -c 'a.0003.exr: cannot be written' errors
ls -A disk
mount -o remount,size=10m disk
batch 2>errors | sed 's/, .*//'
check
END
cat >limit.sh <<'END'
. ./run.sh
nephos render scene.yaml -q --frames 1-2 | sed 's/, .*//'
(ulimit -f 4 && batch 2>errors | grep -v 'is there') || true
grep -c 'a.0003.exr: cannot be written' errors
ls -A disk
batch 2>errors | sed 's/, .*//'
check
END
if unshare --mount mount -t tmpfs tmpfs disk 2>/dev/null; then
  unshare --mount sh -eu fill.sh $pages
else
  sh -eu limit.sh
fi
echo "two processes"
rm -f disk/*
. ./run.sh
batch >first 2>&1 &
batch >second 2>&1
wait $!
check
ls -A disk
