# SPDX-License-Identifier: Apache-2.0
# A field of an atmospheric model: described, checked, exported as .vdb, and refused where it cannot be meant.
cp "$(dirname "$0")/../data/netcdf/ball.nc" .
try() {
  code=0
  nephos "$@" || code=$?
  echo "exit $code"
}
cat >model.yaml <<'END'
version: 1
clouds: [{name: ball, netcdf: ball.nc}]
END
try info ball.nc
try check ball.nc
try check model.yaml
try export model.yaml -o ball.vdb -q
try export model.yaml --set 'clouds[0].netcdf.step=2' -o second.vdb -q
nephos info model.yaml --set "clouds[0].netcdf.droplet_number=50 1/cm3" | grep netcdf
try check ball.nc --fix -o fixed.nc
try export model.yaml --set 'clouds[0].netcdf.variable=x' -o ball.vdb -q
head -c 3000 ball.nc >cut.nc
try info cut.nc
try export model.yaml --set 'clouds[0].netcdf=none.nc' -o ball.vdb -q
