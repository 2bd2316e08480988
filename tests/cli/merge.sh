# SPDX-License-Identifier: Apache-2.0
# Tiles, ranges of samples and both merge to the bits of the whole, in both integrators, and so do pictures and parts;
# they state an error together; what is missing is listed; other pictures, overlaps and damage are refused.
cat >scene.yaml <<'SCENE'
camera: {position: [0, 0, 500 m], look_at: [0, 1 km, 700 m], resolution: [24, 16], overscan: 2}
atmosphere: none
environment: {radiance: 0.1}
clouds: [{name: block, bake: {extent: 1 km, voxel: 200 m, coverage: 1}, position: [0, 2 km, 500 m]}]
render: {samples: 36}
output: {image: "a.####.exr", aovs: [variance, sun, distance, mattes, cryptomatte]}
SCENE
for integrator in march path; do
  run="nephos render scene.yaml -q --integrator $integrator"
  $run >/dev/null
  for range in 0-16 16-32 32-36; do $run --tile 1/2 --sample-range $range >/dev/null; done
  $run --tile 2/2 -o second.npart >/dev/null
  nephos merge a.0001.tile1of2.samples*.npart second.npart -o merged.exr
  nephos compare merged.exr a.0001.exr --exact | tail -n 1
  for tile in 1 2 3; do $run --tile $tile/3 >/dev/null; done
  nephos merge a.0001.tile?of3.exr -o tiles.exr
  nephos compare tiles.exr a.0001.exr --exact | tail -n 1
  $run --tile 1/3 -o first.npart >/dev/null
  nephos merge a.0001.tile3of3.exr first.npart a.0001.tile2of3.exr -o mixed.exr
  nephos compare mixed.exr a.0001.exr --exact | tail -n 1
  nephos info mixed.exr | grep -oE 'nephos:(error|noise)(Min|Max)?' | sort | tr '\n' ' ' && echo
done
ls
nephos merge a.0001.tile1of2.samples16to32.npart -o x.exr || echo "exit $?"
nephos merge a.0001.tile1of3.exr a.0001.tile3of3.exr -o x.exr || echo "exit $?"
nephos merge second.npart a.0001.tile1of2.samples*.npart a.0001.tile3of3.exr -o x.exr || echo "exit $?"
nephos render scene.yaml -q --integrator path --seed 2 --tile 1/2 -o seed.npart >/dev/null
nephos merge seed.npart second.npart -o x.exr || echo "exit $?"
nephos render scene.yaml -q --integrator path --isa x86-64 --tile 1/2 -o isa.npart >/dev/null
nephos merge isa.npart second.npart -o x.exr 2>&1 | sed 's/x86-64-v[34]/BEST/'
head -c 5000 second.npart >cut.npart
nephos merge cut.npart -o x.exr 2>message || echo "exit $?"
sed 's/must have [0-9]* for/must have N for/' message >&2
nephos merge scene.yaml -o x.exr || echo "exit $?"
nephos merge second.npart -o x.png || echo "exit $?"
nephos render scene.yaml --sample-range 0-16 -o x.exr || echo "exit $?"
nephos render scene.yaml -q --sample-range 8-16 -o x.npart || echo "exit $?"
nephos render scene.yaml -q --sample-range 16-8 -o x.npart || echo "exit $?"
nephos render scene.yaml -q --sample-range 0-16 -o x.npart --set output.deep=d.exr || echo "exit $?"
nephos render scene.yaml -q --sample-range 0-16 -o x.npart --target-error 0.1 || echo "exit $?"
nephos render scene.yaml -q --checkpoint 60s --time-limit 10 || echo "exit $?"
ls x.* 2>/dev/null || echo "no x"
