# SPDX-License-Identifier: Apache-2.0
# Tables as pictures, their errors, harmonics; what is no option of a sky, and a folder that is not there.
try() { code=0; "$@" || code=$?; echo "$code"; }
cat >scene.yaml <<'Y'
{camera: {position: [0, 0, 500 m], look_at: [0, 1 km, 500 m]}, sun: {elevation: 30 deg, azimuth: 10 deg}}
Y
mkdir tables
nephos sky scene.yaml -n --tables tables
nephos sky scene.yaml -q --tables tables --verify --paths 64 | sed -E 's/ +[0-9][0-9.e-]*/ N/g'
nephos info tables/sky_view.exr | head -n 1
nephos sky scene.yaml -q --json | sed -E 's/-?[0-9][0-9.e-]*/N/g'
nephos sky scene.yaml -q --verify --json --paths 64 | sed -E 's/-?[0-9][0-9.e-]*/N/g'
try nephos sky scene.yaml -q --tables nowhere
try nephos sky scene.yaml -q --set atmosphere.tolerance=0.5
try nephos sky scene.yaml -q --set atmosphere=none --verify
