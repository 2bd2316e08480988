# SPDX-License-Identifier: Apache-2.0
# A scene of any name: the merges that a job prints take it as its renders do.
cat >scene7 <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
output: {image: "a.####.exr"}
YAML
nephos job parallel scene7 --tiles 2 >job
grep -c 'nephos merge .*scene7' job
for tile in 1/2 2/2; do nephos render scene7 -q --frames 1 --tile $tile >log; done
nephos merge scene7 --frames 1 --tiles 2
nephos merge a.0001.tile1of2.exr a.0001.tile2of2.exr --tiles 2 -o x.exr || echo "exit $?"

# More samples than the picture has are no part of it.
for range in 0-17 0-48 0-4294967295; do
  nephos render scene7 -q --samples 4 --sample-range $range -o x.npart || echo "exit $?"
done
nephos render scene7 -q --samples 4 --sample-range 0-4 -o x.npart >log
nephos merge x.npart -o x.exr
