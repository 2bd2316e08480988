#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the job that `nephos job slurm` prints, by Slurm: slurm.sh PROGRAM
# A farm of one node, without systemd and munge, in namespaces of its own for network and processes, so that it meets no
# other farm and nothing is left of it. Needs root; installs Debian's slurm where it is missing. Steps: tasks of frames
# and tiles, of which one fails once, one is killed in the middle, and some wait for a node that is drained; merging,
# which waits for all; pictures with the bits of one render.
set -eu
if [ "${2:-}" != inside ]; then
  [ "$(id -u)" -eq 0 ] || { echo "skipped: Slurm's daemons and its namespaces need root"; exit 77; }
  if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null; then
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurmctld slurmd \
      slurm-client iproute2 >/dev/null
  fi
  exec unshare --net --pid --uts --mount --fork --mount-proc --kill-child sh "$0" "$1" inside
fi
program=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
work=$(mktemp -d)
controller= node=
end() {
  code=$?
  [ -z "$controller" ] || kill $controller 2>/dev/null || true
  [ -z "$node" ] || kill $node 2>/dev/null || true
  [ $code -eq 0 ] || tail -n 30 "$work"/*.log "$work"/shots/*.log 2>/dev/null || true
  wait
  rm -rf "$work"
  exit $code
}
trap end EXIT
fail() {
  echo "FAILED: $1"
  exit 1
}

# ---- The farm ----

hostname farm
mkdir "$work/state" "$work/spool" "$work/shots"
printf '127.0.0.1 localhost\n10.73.1.1 farm\n' >"$work/hosts"
mount --bind "$work/hosts" /etc/hosts
ip link set lo up
ip address add 10.73.1.1/32 dev lo # a machine without any other address resolves no name
cat >"$work/slurm.conf" <<CONF
ClusterName=farm
SlurmctldHost=farm(10.73.1.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
AuthInfo=cred_expire=5
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000
MinJobAge=3600
KillWait=30
NodeName=farm NodeAddr=10.73.1.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=farm Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$work/slurm.conf"
slurmctld -D -f "$SLURM_CONF" >"$work/slurmctld.log" 2>&1 &
controller=$!
slurmd -D -N farm -f "$SLURM_CONF" >"$work/slurmd.log" 2>&1 &
node=$!

# until_is SECONDS COMMAND...
until_is() {
  left=$(($1 * 5))
  shift
  until "$@" >/dev/null 2>&1; do
    left=$((left - 1))
    [ $left -gt 0 ] || fail "waited in vain for: $*"
    sleep 0.2
  done
}
has_state() { timeout 5 sinfo -h -o %T | grep -qx "$1"; }
until_is 30 has_state idle
echo "a node is up"

# ---- The job ----

. "$(dirname "$0")/failing.sh"
put_failing_program "--frames 2 --tile 1/2"
cd "$work/shots"
cat >scene.yaml <<'SCENE'
camera: {position: [0 m, -3 km, 1100 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [48, 27]}
sun: {elevation: 50 deg, azimuth: 110 deg}
atmosphere: none
clouds:
  - {bake: {preset: cumulus_mediocris, extent: [3 km, 3 km], base: 1200 m, voxel: 150 m}, phase: {hg: 0.6}}
render: {samples: 128, integrator: path}
output: {image: "a.####.exr", preview: "a.####.png", aovs: [variance]}
SCENE
"$program" render scene.yaml -q --frames 1-3 -o 'whole.####.exr' >/dev/null
"$program" job slurm scene.yaml --frames 1-3 --tiles 2 --threads 1 --checkpoint 0.1s >job.sh
scontrol update nodename=farm state=drain reason=test
sh job.sh >jobs
cat jobs
render=$(sed -n 's/^render: job //p' jobs) merge=$(sed -n 's/^merge: job //p' jobs)
sleep 2
[ -z "$(squeue -h -t running -o %i)" ] || fail "a task runs on a drained node"
has_state drained || fail "the node is not drained"
scontrol update nodename=farm state=resume
echo "a node was drained, and is back"

# A task is killed once it has a checkpoint: the one of frame 3, tile 2.
until_is 120 test -e a.0003.tile2of2.npart
task=$(pgrep -f "^$program render [^ ]*/scene.yaml --frames 3 --tile 2/2")
kill -9 $task
echo "a task was killed"

is_over() { [ -z "$(squeue -h -j "$merge" -o %i 2>/dev/null)" ]; }
until_is 300 is_over
count_restarts() { scontrol show job "${render}_$1" | sed -n 's/.*Restarts=\([0-9]*\).*/\1/p'; }
[ -e "$work/failed" ] || fail "no task has failed"
[ "$(count_restarts 2)" = 1 ] || fail "the task that failed was not run again: Restarts=$(count_restarts 2)"
[ "$(count_restarts 5)" = 1 ] || fail "the task that was killed was not run again: Restarts=$(count_restarts 5)"
[ "$(count_restarts 0)" = 0 ] || fail "a task that did not fail was run again"
for frame in 1 2 3; do
  "$program" compare a.000$frame.exr whole.000$frame.exr --exact >compared || fail "frame $frame: $(cat compared)"
  [ -e a.000$frame.png ] || fail "frame $frame has no preview"
done
[ -z "$(ls *.npart 2>/dev/null)" ] || fail "a checkpoint is left"
echo "the frames have the bits of one render"
