# SPDX-License-Identifier: Apache-2.0
# Views and depths of a preview; a tile, a crop and a frame of a sequence are exposed alike, by the light on the scene.
cat >scene.yaml <<'YAML'
camera: {position: [0, 0, 1 km], look_at: [0, 6 km, 1500 m], resolution: [32, 18]}
sun: {elevation: 20 deg}
output: {preview: whole.png}
YAML
nephos render scene.yaml -q --set output.view=raw >/dev/null
grep -ac gAMA whole.png
grep -ac sRGB whole.png || true
for view in camera filmic standard; do
  nephos render scene.yaml -q --set output.view=$view -o $view.png >/dev/null
  grep -ac sRGB $view.png
done
cat >config.ocio <<'OCIO'
ocio_profile_version: 2
roles: {default: raw}
displays: {monitor: [!<View> {name: plain, colorspace: gamma}]}
colorspaces:
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace> {name: gamma, from_scene_reference: !<ExponentTransform> {value: 0.5}}
OCIO
nephos render scene.yaml -q --set 'output.view={ocio: config.ocio}' -o ocio.png >/dev/null
grep -ac sRGB ocio.png || true
nephos render scene.yaml -q --set 'output.view={ocio: config.ocio, display: wall}' 2>&1 || echo "exit $?"
nephos render scene.yaml -q --set 'output.view={display: monitor}' 2>&1 || echo "exit $?"
for bits in 8 16; do
  nephos render scene.yaml -q --set output.preview_bits=$bits -o deep.png >/dev/null
  od -A n -t u1 -j 24 -N 1 deep.png
done
for integrator in march path; do
  expose() { nephos render scene.yaml -v --integrator $integrator "$@" 2>&1 >/dev/null | sed -n 's/.*preview: //p'; }
  expose --set output.exposure=meter >whole
  for part in '--tile 1/2' '--tile 2/2' '--crop 0,0,4,4' '-o frame.####.png'; do expose $part | cmp - whole; done
  expose | cmp -s - whole || echo 'the whole is exposed by itself'
done
nephos render scene.yaml -q --set output.exposure=dark 2>&1 | sed 's/.*output/output/'
