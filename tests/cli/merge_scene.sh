# SPDX-License-Identifier: Apache-2.0
# Tiles of a scene's frames are merged by the names that the scene gives them, with previews; frames without all of
# their tiles are reported, and the rest goes on. Previews have the bits of the whole's, of halves and of floats, of
# frames, which are exposed by the light, and of a still, which is exposed by itself.
cat >scene.yaml <<'SCENE'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 33}}
render: {samples: 1}
output: {image: "a.####.exr", preview: "a.####.png"}
SCENE
nephos render scene.yaml -q --frames 1-3 >/dev/null
mkdir whole && mv a.* whole
for tile in 1 2; do nephos render scene.yaml -q --frames 1-3 --tile $tile/2 >/dev/null; done
nephos merge scene.yaml --frames 1-2 --tiles 2
for frame in 1 2; do
  nephos compare a.000$frame.exr whole/a.000$frame.exr --exact | head -n 1
  cmp a.000$frame.png whole/a.000$frame.png
done
rm a.0002.tile1of2.exr
nephos merge scene.yaml --frames 1-3 --tiles 2 --json -q || echo "exit $?"
nephos merge scene.yaml --frames 2 --tiles 2 || echo "exit $?"
nephos merge a.0003.tile2of2.exr a.0003.tile1of2.exr -o b.exr -o b.png
ls b.*
nephos merge a.0003.tile1of2.exr a.0003.tile2of2.exr -o b.exr --tiles 2 || echo "exit $?"
nephos merge scene.yaml --frames 1 || echo "exit $?"
nephos merge scene.yaml --frames 1 --tiles 2 -o b.exr || echo "exit $?"
nephos merge a.0003.tile1of2.exr -o b.png || echo "exit $?"
for type in half float; do
  for samples in 1 32; do
    still="--set output.image=s.exr --set output.preview=s.png --set output.pixel_type=$type --samples $samples"
    nephos render scene.yaml -q $still >/dev/null && mv s.png whole.png
    for tile in 1 2; do nephos render scene.yaml -q $still --tile $tile/2 >/dev/null; done
    nephos merge s.tile1of2.exr s.tile2of2.exr -o s.exr -o s.png
    cmp s.png whole.png
  done
  for range in 0-16 16-32; do nephos render scene.yaml -q $still --sample-range $range >/dev/null; done
  nephos merge s.samples*.npart -o s.exr -o s.png
  cmp s.png whole.png
  rm s.*
done
