# SPDX-License-Identifier: Apache-2.0
# The look of pictures in figures: sharpness, relief, glare of the air, noise of edges, an approach. Prints a table.
#
#   sh look.sh NEPHOS [SEED [DETAIL [COVER]]]
#
# NEPHOS   the program, with the library and the Python package of its build beside it (target nephos_python); Python has
#          numpy and scipy
# SEED     seed of the clouds; 4711
# DETAIL   their clouds[].detail, auto; or none
# COVER    terrain.ground_cover of the ground, temperate
#
# Each row has a criterion, its value and its limit. Limits are those of photographs: a value beyond its limit is a
# shortcoming, not a failure.
set -eu
export LC_ALL=C
nephos=$(realpath "$1")
build=$(dirname "$(dirname "$nephos")")
export NEPHOS_LIBRARY="$build/lib/libnephos.so" PYTHONPATH="$build/python"
/usr/bin/python3 -c 'import nephos, numpy, scipy' 2>/dev/null || {
  echo "look.sh needs the Python package in $build/python (ninja nephos_python), numpy and scipy" >&2
  exit 1
}
seed=${2:-4711}
detail=${3:-auto}
cover=${4:-temperate}
here=$(dirname "$(realpath "$0")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# A congestus with the sun behind the camera: 3.1 m a pixel at 960 pixels, 7 m at 425.
cat >congestus.yaml <<END
version: 1
camera: {position: [-2.2 km, -4.6 km, 1.4 km], look_at: [0 m, 0 m, 2.3 km], fov: 32 deg, resolution: [960, 540]}
sun: {elevation: 38 deg, azimuth: 235 deg}
clouds:
  - bake: {preset: cumulus_congestus, seed: $seed, extent: [5 km, 5 km], cell: 2400 m, thickness: 2800 m,
           coverage: 0.35, voxel: 20 m}
    detail: $detail
render: {samples: 4}
END
cat >sky.yaml <<END
version: 1
camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 100 m, 68 m], fov: 20 deg, resolution: [201, 113]}
sun: {elevation: 30 deg, azimuth: 0 deg}
output: {film: {disks: false}}
END
cat >horizon.yaml <<END
version: 1
camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 100 m, 10 m], roll: 3 deg, fov: 40 deg, resolution: [240, 24]}
sun: {elevation: 40 deg, azimuth: 120 deg}
render: {samples: 4}
END
# Cloud at noon, with sky 60° from the sun beside it.
cat >noon.yaml <<END
version: 1
camera: {position: [-2.6 km, -5.4 km, 1.2 km], look_at: [0 m, 0 m, 2.2 km], fov: 50 deg, resolution: [480, 270]}
sun: {elevation: 55 deg, azimuth: 100 deg}
clouds:
  - bake: {preset: cumulus_congestus, seed: $seed, extent: [5 km, 5 km], cell: 2400 m, thickness: 2800 m,
           coverage: 0.35, voxel: 20 m}
    detail: $detail
render: {samples: 4}
END
# Mountains from above.
cat >ground.yaml <<END
version: 1
camera: {position: [-3 km, -7 km, 2600 m], look_at: [0 m, -1 km, 500 m], fov: 40 deg, resolution: [480, 270]}
sun: {elevation: 40 deg, azimuth: 250 deg}
terrain: {ridges: {seed: $seed, relief: 1500 m}, width: 24 km, ground_cover: $cover}
render: {samples: 16}
END
cat >low.yaml <<END
version: 1
camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 100 m, 25 m], fov: 60 deg, resolution: [96, 54]}
sun: {elevation: 1 deg, azimuth: 60 deg}
output: {exposure: meter}
render: {samples: 2}
END
# One cloud, which a camera approaches from 3 km to 150 m before it.
cat >approach.yaml <<END
version: 1
camera: {position: [-3 km, -5 km, 1.4 km], look_at: [0 m, 0 m, 1.8 km], fov: 50 deg, resolution: [160, 90]}
sun: {elevation: 38 deg, azimuth: 235 deg}
clouds:
  - bake: {preset: cumulus_congestus, model: hero, seed: $seed, extent: [4 km, 4 km], thickness: 2400 m, voxel: 20 m}
    detail: $detail
render: {samples: 2}
output: {aovs: [depth]}
END
# The 2° above the horizon of the ground under a deck by default.
cat >deck.yaml <<END
version: 1
camera: {position: [0 m, 0 m, 20 m], look_at: [0 m, 100 m, 21.8 m], fov: 20 deg, resolution: [160, 16]}
sun: {elevation: 35 deg, azimuth: 120 deg}
clouds:
  - bake: {preset: stratocumulus, seed: $seed}
render: {samples: 4}
END
# Bases of cumulus at the camera's height, 4.5 m a pixel at 4 km.
cat >base.yaml <<END
version: 1
camera: {position: [0 m, -4 km, 1.2 km], look_at: [0 m, 0 m, 1.2 km], fov: 30 deg, resolution: [480, 160]}
sun: {elevation: 38 deg, azimuth: 235 deg}
clouds:
  - bake: {preset: cumulus_mediocris, seed: $seed, extent: [4 km, 2 km], coverage: 0.4, voxel: 20 m}
    detail: $detail
render: {samples: 4}
END
sed '/^sun/a atmosphere: {haze: hazy}' sky.yaml >haze.yaml
"$nephos" render -q congestus.yaml --cache cache -o near.exr
"$nephos" render -q congestus.yaml --cache cache -o far.exr --resolution 425x239
"$nephos" render -q sky.yaml -o sky.exr
"$nephos" render -q haze.yaml -o haze.exr -o haze.png
"$nephos" render -q ground.yaml -o ground.exr
for elevation in 6 5 4 3 2 1 0 -1 -2; do
  "$nephos" render -q low.yaml --set "sun.elevation=$elevation deg" -o low$elevation.png
done
"$nephos" render -q noon.yaml --cache cache -o noon.exr -o noon.png
"$nephos" render -q deck.yaml -o deck.exr
"$nephos" render -q base.yaml -o base.exr
"$nephos" render -q horizon.yaml -o horizon.exr
"$nephos" render -q horizon.yaml -o horizon_mean.exr --samples 64

"$nephos" render -q approach.yaml --cache cache -o approach.exr
/usr/bin/python3 "$here/look_approach.py" approach.exr >places
while IFS=';' read -r frame position target; do
  "$nephos" render -q approach.yaml --cache cache -o "approach$frame.exr" --set "camera.position=$position" \
    --set "camera.look_at=$target" </dev/null
done <places
/usr/bin/python3 "$here/look_page.py" "$work"
