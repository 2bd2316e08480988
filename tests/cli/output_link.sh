# SPDX-License-Identifier: Apache-2.0
# A symbolic link stays one, and its end is written, also where that is not there yet; where it cannot be there, that is
# said before any work.
cat >scene.yaml <<'YAML'
camera: {resolution: [4, 2]}
atmosphere: none
environment: {planet: none, radiance: 0.1}
YAML
mkdir shelf
ln -s shelf/b.exr a.exr
nephos render scene.yaml -q -o a.exr
nephos render scene.yaml -q -o a.exr
readlink a.exr
nephos compare a.exr shelf/b.exr --exact -q | tail -n 1
ls -A shelf
ln -s gone/d.exr c.exr
nephos render scene.yaml -q -o c.exr --dry-run || echo "exit $?"
nephos render scene.yaml -q -o c.exr || echo "exit $?"
nephos render scene.yaml -q -o /dev/null/e.exr --dry-run || echo "exit $?"
ls -A
