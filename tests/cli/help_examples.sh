# SPDX-License-Identifier: Apache-2.0
# Each example of each verb's help works.
cat >scene.yaml <<'SCENE'
camera: {position: [0, -6 km, 2500 m], look_at: [0, 0, 1 km], resolution: [64, 36]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 129}}
output: {image: "frame.####.exr", preview: "frame.####.png"}
SCENE
cat >clear.yaml <<'SCENE'
atmosphere: {tolerance: 0.1}
SCENE
cat >clouds.yaml <<'SCENE'
clouds: [{name: low, bake: {preset: cumulus_humilis, extent: 1 km, voxel: 50 m, coverage: 0.8}}]
SCENE
printf 'quantity,g,albedo,tau,mu0\nflux,0.85,1,0,diffuse\n' >slabs.csv
printf 'quantity,earth,max_order,h_km,mu,sun_zenith_deg\ntransmittance_top,earth,,0,1,\n' >skies.csv
cp -r "$(dirname "$0")/../data/i3rc" i3rc
nephos render scene.yaml -q -o frame.exr >log
cp frame.exr reference.exr
for half in 1 2; do
  nephos render scene.yaml -q --tile $half/2 --frames 1-3 >log
  nephos render scene.yaml -q --tile $half/2 -o frame.tile$half.exr >log
  nephos render scene.yaml -q --samples 32 --sample-range $((16 * half - 16))-$((16 * half)) -o frame.samples$half.npart >log
done
for verb in $(nephos --help | sed -n '/^verbs:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
  nephos help "$verb" | sed -n '/^examples:/,$s/^  \(nephos .*\)/\1/p' >examples
  [ -s examples ] || echo "FAILED: $verb has no example: add one to its row in cli/command_$verb.c"
  while read -r example; do
    echo "$example"
    case $example in
    "nephos report "*) example=$(echo "$example" | sed 's/--budget [0-9]*s/--budget 1s/') ;; # as a longer one
    "nephos view "*) example="timeout --foreground --preserve-status -s INT 2 $example" ;; # it serves until it is interrupted
    esac
    sh -euc "$example" >log 2>errors </dev/null || { echo "FAILED: $example"; cat errors; }
  done <examples
done
nephos render scene.yaml -h | cmp - /dev/fd/3 3<<END
$(nephos help render)
END
nephos help scene | grep -A 1 '^  camera.fov '
if nephos help rendr; then exit 99; else [ $? -eq 2 ]; fi
if nephos help render -o folder; then exit 99; else [ $? -eq 2 ]; fi
