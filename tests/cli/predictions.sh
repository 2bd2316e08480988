# SPDX-License-Identifier: Apache-2.0
# -v of a render, -n and --explain predict the same seconds, memory and error, with and without a target.
cat >scene.yaml <<'YAML'
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], resolution: [32, 18]}
clouds: [{bake: {preset: cumulus_humilis, extent: [2 km, 2 km], voxel: 50 m}}]
render: {samples: 2}
YAML
# "prediction: 1.23 s of one core, 45.6 MB, error 7.89 %"
read_log() { sed -n 's/.*prediction: \([^;]*%\).*/\1/p' | head -1; }
read_json() {
  sed -n '/"prediction"/,/}/p' | sed -n 's/.*"\(seconds\|bytes\|error\)": \([0-9.e+-]*\).*/\1 \2/p' |
    awk '{v[$1] = $2} END {printf "%.3g s of one core, %.3g MB, error %.3g %%\n", v["seconds"], v["bytes"] / 1e6, 100 * v["error"]}'
}
for options in '' '--target-error 5'; do
  nephos render scene.yaml $options --explain --json | read_json >explained
  nephos render scene.yaml $options -n -v -o a.exr 2>&1 >/dev/null | read_log >rehearsed
  nephos render scene.yaml $options -v -o a.exr 2>&1 >/dev/null | read_log >rendered
  cmp explained rehearsed
  cmp explained rendered
  grep -c 's of one core' rendered
done
