# SPDX-License-Identifier: Apache-2.0
# Files made to do harm are read (0), or refused (5) with one line, within 5 s of a processor and 256 MB besides the 300 MB
# of addresses that the program and its libraries have. Without sanitizers, which take terabytes of addresses.
data=$(dirname "$0")/../data
try() {
  code=0
  (ulimit -t 5 && ulimit -v 556000 && nephos "$@" -t 1 >out 2>err) || code=$?
  shift $(($# - 1))
  echo "exit $code, $(wc -l <err) lines: $(basename "$1")"
}
for file in "$data"/hostile/*.vdb; do
  try info "$file"
  try info --json "$file"
done

# OpenVDB would print about a format newer than it knows on standard output.
cp "$data/vdb/frustum.vdb" newer.vdb
printf '\341' | dd of=newer.vdb bs=1 seek=8 conv=notrunc 2>/dev/null
try info --json newer.vdb
cat err
head -n 1 out

# Two scenes that name such files
for name in leak-c83e811 leak-09c4906; do
  cat >scene.yaml <<END
camera: {position: [0 m, -300 m, 0 m], look_at: [0, 0, 0], resolution: [16, 9]}
clouds: [{vdb: $data/hostile/$name.vdb, grid: density, optical_depth: 4}]
output: {image: a.exr}
END
  try render -q scene.yaml
done
