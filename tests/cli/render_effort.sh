# SPDX-License-Identifier: Apache-2.0
# Targets, limits and calibrations of a render: the choice, predictions beside what came, and what is refused.
cat >scene.yaml <<'END'
camera: {position: [0, -3 km, 1100 m], look_at: [0, 0, 1500 m], resolution: [16, 9]}
clouds: [{bake: {preset: cumulus_humilis, extent: [2 km, 2 km], base: 1200 m, voxel: 100 m}}]
atmosphere: {tolerance: 0.05}
END
nephos render scene.yaml -q --target-error 0.5 --explain | sed -n 's/^settings *\(quality [a-z]*, [a-z]*\).*/\1/p'
nephos render scene.yaml -q --target-error 0.02 --explain | sed -n 's/^settings *\(quality [a-z]*, [a-z]*\).*/\1/p'
# The limit wins: a picture, exit code 0, and a warning of the error that was reached.
nephos render scene.yaml -q --target-error 0.01 --time-limit 20 --integrator march -o a.exr 2>&1 |
  sed -E 's/[0-9.]+ %/N %/g; s/noise [0-9.]+/noise N/; s/about [0-9.]+/about N/'
nephos render scene.yaml -q --target-error 0.5 --json -o a.exr >line 2>&1
for key in predicted_seconds predicted_bytes predicted_error pilot_seconds pilot_error cpu_seconds; do
  grep -o "\"$key\"" line
done
# A calibration that is damaged, of another machine, or not there.
echo '{"format": "nephos machine"}' >machine.json
nephos render scene.yaml -q --explain --machine machine.json && exit 99
echo '{"format": "nephos machine", "version": "1", "cpu": "MOS 6502", "terrain": 1, "bake": 1, "sky": 1, "solve": 1, "march": 1, "path": 1}' >machine.json
nephos render scene.yaml -q --explain --machine machine.json 2>&1 >/dev/null | grep -o 'measured with MOS 6502'
nephos render scene.yaml -q --explain --machine none.json && exit 99
mkdir -p "$XDG_CACHE_HOME/nephos"
echo '{' >"$XDG_CACHE_HOME/nephos/machine.json"
nephos render scene.yaml -q --explain >/dev/null 2>&1 && exit 99
rm "$XDG_CACHE_HOME/nephos/machine.json"
nephos report --calibrate scene.yaml && exit 99
nephos report
