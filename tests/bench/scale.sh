# SPDX-License-Identifier: Apache-2.0
# Threads and shards: prints the tables of docs/results/scale.md.
#
#   sh scale.sh NEPHOS [threads|serial|shards]
#
# threads: best wall time of RUNS on one and on two threads, and the efficiency T1/(2·T2); for a machine that does
# nothing else.
# serial: CPU seconds on one thread; share of them in the calling thread, for which all others wait (by perf, which also
# counts OpenVDB being loaded); the efficiency of two threads that this leaves, 1/(1 + share).
# shards: tiles of a frame; CPU seconds of all, the first into an empty --cache; their cost over the whole; megabytes of
# the cache.
set -eu
export LC_ALL=C
nephos=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
only=${2:-threads serial shards}
runs=${RUNS:-5}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
samples=$(cd "$(dirname "$0")/../../samples" && pwd)
cd "$work"
sed 's#out/##; s/, *preview: [^,]*//' "$samples/cumulus_field.yaml" >scene.yaml
cat >path.yaml <<'END'
camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 1400 m], fov: 50 deg, resolution: [160, 90]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds: [{name: field, bake: {preset: cumulus_humilis, seed: 3, extent: 2 km, voxel: 40 m, coverage: 0.6}}]
render: {integrator: path, samples: 16}
output: {image: path.exr}
END
cat >bake.yaml <<'END'
clouds: [{name: field, vdb: bake.vdb, bake: {preset: cumulus_mediocris, seed: 12, extent: 12 km, voxel: 30 m}}]
END

# CPU seconds of a command and all that it started.
measure_cpu() { # COMMAND...
  ( "$@" >/dev/null; times ) |
    awk 'END { split($1, u, "m"); split($2, s, "m"); printf "%.2f", 60 * (u[1] + s[1]) + u[2] + s[2] }'
}

measure_wall() { # COMMAND...
  begin=$(date +%s.%N)
  "$@" >/dev/null
  echo "$begin $(date +%s.%N)" | awk '{ printf "%.3f\n", $2 - $1 }'
}

measure_best() { # COMMAND...
  for run in $(seq "$runs"); do measure_wall "$@"; done | sort -n | head -n 1
}

# Arguments of a kind of work.
get_work() { # KIND
  case $1 in
  path) echo render path.yaml ;;
  bake) echo bake bake.yaml ;;
  march) echo render scene.yaml --resolution 480x270 ;;
  esac
}

print_threads() {
  "$nephos" bake scene.yaml -q >/dev/null
  for kind in path bake march; do
    one=$(measure_best "$nephos" $(get_work $kind) -q -t 1)
    two=$(measure_best "$nephos" $(get_work $kind) -q -t 2)
    echo "$kind $one $two" | awk '{ printf "| %s | %.2f | %.2f | %.0f %% |\n", $1, $2, $3, 50 * $2 / $3 }'
  done
}

# The calling thread has the lowest number.
print_serial() {
  "$nephos" bake scene.yaml -q >/dev/null
  for kind in path bake march; do
    rm -f bake.vdb
    perf record -q -F 500 -o perf.data -- "$nephos" $(get_work $kind) -q -t 1 >/dev/null
    perf script -i perf.data -F tid | awk -v kind=$kind '
      { count[$1]++; if (!least || $1 + 0 < least) least = $1 + 0 }
      END { for (t in count) all += count[t]
            share = count[least] / all
            printf "| %s | %.1f | %.1f %% | %.0f %% |\n", kind, all / 500, 100 * share, 100 / (1 + share) }'
  done
}

render_tiles() { # COUNT
  for tile in $(seq "$1"); do
    "$nephos" render scene.yaml -q -t 1 --resolution "${SIZE:-1920x1080}" --cache cache.$1 --tile $tile/$1 \
      -o t$1.$tile.exr
  done
}

print_shards() {
  "$nephos" bake scene.yaml -q >/dev/null
  whole=$(measure_cpu "$nephos" render scene.yaml -q -t 1 --resolution "${SIZE:-1920x1080}" -o whole.exr)
  echo "| 1 | $whole | | |"
  for count in ${COUNTS:-2 4 8 16 64}; do
    all=$(measure_cpu render_tiles $count)
    "$nephos" merge t$count.*.exr -o merged.exr >/dev/null
    "$nephos" compare merged.exr whole.exr --exact >/dev/null || echo "the tiles are not the whole"
    kept=$(du -sk cache.$count | cut -f 1)
    echo "$count $all $whole $kept" | awk '{ printf "| %d | %.1f | %.2f | %d |\n", $1, $2, $2 / $3, $4 / 1000 }'
    rm -rf cache.$count t$count.*
  done
}

for part in $only; do print_$part; done
