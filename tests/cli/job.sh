# SPDX-License-Identifier: Apache-2.0
# The job of each farm: that of OpenCue was held to the published cjsl-1.12.dtd; tests/farms holds that of Open Job
# Description to the rules of its specification, and runs those of Slurm and GNU parallel.
mkdir shots
cat >"shots/dawn 2.yaml" <<'YAML'
clouds: [{bake: {extent: 1 km}}]
output: {image: "a.####.exr"}
YAML
for farm in slurm openjd opencue parallel; do
  echo "== $farm, frames"
  nephos job $farm "shots/dawn 2.yaml" --frames 1-9x2,20 |
    sed "s|$PWD|FOLDER|; s|<user>.*</user>|<user>USER</user>|; s|<uid>.*</uid>|<uid>UID</uid>|"
  echo "== $farm, chunks and tiles"
  nephos job $farm "shots/dawn 2.yaml" --frames 12,1-8,4 --chunk 4 --tiles 2 --checkpoint 5m -t 2 \
    -- --samples 8 --set 'output.preview=the "p" & <q>.####.png' |
    sed "s|$PWD|FOLDER|; s|<user>.*</user>|<user>USER</user>|; s|<uid>.*</uid>|<uid>UID</uid>|"
done
nephos job slurn scene.yaml || echo "exit $?"
nephos job slurm missing.yaml || echo "exit $?"
nephos job slurm "shots/dawn 2.yaml" --frames 1-2 -- --set output.image=a.exr || echo "exit $?"
nephos job slurm "shots/dawn 2.yaml" -- --tile 1/2 || echo "exit $?"
nephos job slurm "shots/dawn 2.yaml" -- --sample 3 || echo "exit $?"
nephos job openjd "shots/dawn 2.yaml" --frames 1-4000 --chunk 3 || echo "exit $?"
nephos job openjd "shots/dawn 2.yaml" -- --set 'output.preview=a{{x}}.####.png' || echo "exit $?"
cat >sequence.yaml <<'YAML'
clouds: [{name: smoke, vdb: "smoke.####.vdb", position: [0, 0, 1 km], optical_depth: 10}]
output: {image: "a.####.exr"}
YAML
nephos job parallel sequence.yaml --frames 1-3 >several.txt
nephos job parallel sequence.yaml --frames 1-3 --chunk 3 >one.txt
nephos job parallel sequence.yaml --frames 1-3 -- --set 'clouds[0].reference_frame=1' >given.txt
