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
    sed -E "s/[0-9.e+]+ MB and [0-9.e+-]+ s are/N MB and N s are/; s/--mem=[0-9]+M/--mem=NM/; s/--time=[0-9]+/--time=N/; \
      s|$PWD|FOLDER|g; s|<user>.*</user>|<user>USER</user>|; s|<uid>.*</uid>|<uid>UID</uid>|"
  echo "== $farm, chunks and tiles"
  nephos job $farm "shots/dawn 2.yaml" --frames 12,1-8,4 --chunk 4 --tiles 2 --checkpoint 5m -t 2 \
    -- --samples 8 --set 'output.preview=the "p" & <q>.####.png' |
    sed -E "s/[0-9.e+]+ MB and [0-9.e+-]+ s are/N MB and N s are/; s/--mem=[0-9]+M/--mem=NM/; s/--time=[0-9]+/--time=N/; \
      s|$PWD|FOLDER|g; s|<user>.*</user>|<user>USER</user>|; s|<uid>.*</uid>|<uid>UID</uid>|"
done
for checkpoint in " 60s" "
60s"; do
  nephos job slurm "shots/dawn 2.yaml" --checkpoint "$checkpoint" >job.sh || echo "exit $?"
done
printf 'output: {image: a.exr}\n' >"$(printf 'a\ntouch INJECTED\n.yaml')"
for farm in slurm openjd opencue parallel; do
  nephos job $farm "$(printf 'a\ntouch INJECTED\n.yaml')" | sed "s|$PWD|FOLDER|g"
  nephos job $farm "shots/dawn 2.yaml" -- --set "$(printf 'output.preview=a\r.####.png')" || echo "exit $?"
done
nephos job opencue "shots/dawn 2.yaml" -- --set 'output.preview=$HOME.####.png' || echo "exit $?"
nephos job opencue "shots/dawn 2.yaml" -- --set "$(printf 'output.preview=\377.####.png')" || echo "exit $?"
nephos job slurm - </dev/null || echo "exit $?"
nephos job slurm "shots/dawn 2.yaml" -- -- || echo "exit $?"
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

# Tasks of Slurm ask for 1.5 times the memory that --explain predicts and 256 MB, and for 4 times the time and 10 minutes.
cat >long.yaml <<'YAML'
camera: {resolution: [640, 360]}
clouds: [{bake: {extent: 2 km, voxel: 50 m}}]
render: {integrator: path, samples: 4096}
output: {image: "a.####.exr"}
YAML
nephos render long.yaml --explain | sed -n 's/^prediction *\([0-9.e+]*\) s, \([0-9.]*\) MB.*/\1 \2/p' >explained
nephos job slurm long.yaml -t 2 | sed -n 's/#SBATCH --mem=\(.*\)M/\1/p; s/#SBATCH --time=//p' | tr '\n' ' ' >asked
cat explained asked | awk '
  function is_near(a, b) { return a / b > 0.94 && a / b < 1.06 }
  NR == 1 { mib = (1.5e6 * $2 + 256e6) / 1048576; minutes = (4 * $1 / 2 + 600) / 60 }
  NR == 2 { print is_near($1, mib) && is_near($2, minutes) ? "as explained" : $1 " MiB, " $2 " min, not " mib ", " minutes }'
