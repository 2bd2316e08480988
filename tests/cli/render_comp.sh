# SPDX-License-Identifier: Apache-2.0
# Layers merged by another program are the picture, and the deep picture flattens to the layer of the clouds.
cat >scene.yaml <<'SCENE'
camera: {position: [0 m, -3 km, 500 m], look_at: [0 m, 0 m, 900 m], fov: 50 deg, resolution: [24, 16], overscan: 2}
clouds:
  - {name: hero, bake: {preset: cumulus_humilis, seed: 3, extent: [1200 m, 900 m], base: 700 m, thickness: 500 m,
     voxel: 100 m, coverage: 1}}
terrain: {ridges: {samples: 33}, width: 12 km}
output: {image: flat.exr, deep: deep.exr, pixel_type: float, alpha: clouds,
  aovs: [clouds, ground_air, terrain, background]}
SCENE

# layer NAME: it alone, as R, G and B.
layer() { oiiotool flat.exr --ch "R=$1.R,G=$1.G,B=$1.B" -o "$1.exr"; }

for integrator in march path; do
  echo "$integrator"
  nephos render scene.yaml -q --integrator $integrator
  for name in ground_air terrain background; do layer $name; done
  oiiotool flat.exr --ch R=clouds.R,G=clouds.G,B=clouds.B,A=clouds.A -o clouds.exr
  oiiotool clouds.exr --ch R,G,B ground_air.exr --add terrain.exr --add background.exr --add -o merged.exr
  oiiotool flat.exr --ch R,G,B merged.exr --fail 1e-5 --diff
  oiiotool deep.exr --flatten --ch R,G,B,A clouds.exr --ch R,G,B,A --fail 1e-3 --diff
  oiiotool flat.exr --ch A clouds.exr --ch A --fail 0 --diff
  oiiotool --info -v deep.exr | grep -e window -e origin -e "channel list"
done
