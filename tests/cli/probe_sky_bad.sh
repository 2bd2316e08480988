# SPDX-License-Identifier: Apache-2.0
# Each with its exit code.
try() { code=0; "$@" || code=$?; echo "$code"; }
head='quantity,earth,max_order,h_km,mu,sun_zenith_deg,view_zenith_deg,rel_azimuth_deg,distance_km'
# row FIELDS…: a table of one row
row() { printf '%s\n' "$head" "$1" >bad.csv; try nephos probe sky bad.csv -q; }
row 'colour,earth,,0,,0,0,0,'
row 'sky_radiance,venus,,0,,0,0,0,'
row 'sky_radiance,earth,1.5,0,,0,0,0,'
row 'sky_radiance,earth,-1,0,,0,0,0,'
row 'sky_radiance,earth,,-1,,0,0,0,'
row 'sky_radiance,earth,,0,,,0,0,'
row 'transmittance_top,earth,,0,1.1,,,,'
row 'ap_inscatter,earth,,0,,30,80,0,nan'
printf 'quantity,earth,h_km\nsky_irradiance,earth,0\n' >bad.csv
try nephos probe sky bad.csv -q
printf 'quantity,h_km\n' >bad.csv
try nephos probe sky bad.csv -q
try nephos probe sky missing.csv -q
try nephos probe sky bad.csv --method guess
try nephos probe sky bad.csv --integrator path
try nephos probe slab bad.csv --method lut
try nephos probe sky bad.csv --target-error 0.1
