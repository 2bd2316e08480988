# SPDX-License-Identifier: Apache-2.0
# A new file has the permissions that the umask leaves; one that replaces another has those of the other.
cat >scene.yaml <<'YAML'
camera: {resolution: [8, 4]}
atmosphere: none
environment: {planet: none, radiance: 0.1}
clouds: [{name: low, bake: {preset: cumulus_mediocris, extent: 1 km, voxel: 100 m}, optical_depth: 1}]
YAML
show() { stat -c '%a %n' a.exr a.png low.vdb; }
write() {
  nephos render scene.yaml -q -o a.exr -o a.png >/dev/null
  nephos bake scene.yaml -q >/dev/null
}
umask 027
write
show
umask 022
chmod 600 a.exr
chmod 664 a.png
chmod 606 low.vdb
write
show
