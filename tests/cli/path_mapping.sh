# SPDX-License-Identifier: Apache-2.0
# Names of files in a scene are mapped by the rules that Open Job Description writes: by the longest that is a folder of
# the name, of POSIX and of Windows; relative names, and those of which no rule is a folder, stay.
mkdir -p here/maps here/out
cat >scene.yaml <<'YAML'
camera: {resolution: [16, 9]}
atmosphere: none
environment: {radiance: 0.1}
terrain: {ridges: {samples: 33}, albedo_image: '/studio/show/hills/a.png'}
output: {image: 'S:\Show\out\a.exr'}
YAML
cat >rules.json <<JSON
{"version": "pathmapping-1.0", "path_mapping_rules": [
  {"source_path_format": "POSIX", "source_path": "/studio", "destination_path": "$PWD/wrong"},
  {"source_path_format": "POSIX", "source_path": "/studio/show/hills/", "destination_path": "$PWD/here/maps"},
  {"source_path_format": "POSIX", "source_path": "/studio/show/hill", "destination_path": "$PWD/wrong"},
  {"source_path_format": "WINDOWS", "source_path": "s:\\\\show", "destination_path": "$PWD/here"}
]}
JSON
mapped() { nephos render scene.yaml --path-mapping "$@" 2>&1 | sed "s|$PWD|FOLDER|; s/, .*//"; }
mapped rules.json -n
nephos render scene.yaml -q -o here/maps/a.png --set 'terrain={ridges: {samples: 33}}' >/dev/null
mapped rules.json -n
mapped rules.json -q
mapped rules.json -n --set output.image=b.exr
echo '{}' >empty.json
mapped empty.json -n
for text in '[]' 'rules' '{"version": "pathmapping-9"}' '{"path_mapping_rules": [{"source_path": "/a"}]}' \
  '{"path_mapping_rules": [{"source_path_format": "MAC", "source_path": "/a", "destination_path": "/b"}]}'; do
  echo "$text" >bad.json
  nephos render scene.yaml -n --path-mapping bad.json || echo "exit $?"
done
nephos render scene.yaml -n --path-mapping missing.json || echo "exit $?"

# Rules are a regular file, and a text ends.
nephos render scene.yaml -n --path-mapping /dev/zero || echo "exit $?"
ln -s /dev/zero zero.yaml
nephos info zero.yaml || echo "exit $?"
truncate -s 65M rules.json
nephos render scene.yaml -n --path-mapping rules.json || echo "exit $?"
