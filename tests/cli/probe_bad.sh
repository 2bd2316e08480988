# SPDX-License-Identifier: Apache-2.0
# Each with its exit code.
try() { code=0; "$@" || code=$?; echo "$code"; }
head='quantity,g,albedo,tau,mu0,mu_view,phi_deg'
# row FIELDS…: a table of one row
row() { printf '%s\n' "$head" "$1" >bad.csv; try nephos probe slab bad.csv -q; }
row 'flux,1,1,1,1,,'
row 'flux,0,1.5,1,1,,'
row 'flux,0,1,nan,1,,'
row 'flux,0,1,1,sideways,,'
row 'radiance_top_up,0,1,1,1,-0.5,0'
row 'radiance_bottom_down,0,1,1,1,-0.5,'
row 'albedo,0,1,1,1,,'
row 'flux,0,1,1,1'
row 'flux,0,1,1,1,"x,'
printf 'quantity,g,albedo,mu0\n' >bad.csv
try nephos probe slab bad.csv -q
: >bad.csv
try nephos probe slab bad.csv -q
try nephos probe slab missing.csv -q
try nephos probe soup bad.csv
try nephos probe slab bad.csv --integrator guess
try nephos probe slab bad.csv -o out.exr
try nephos probe slab bad.csv --seed -1
try nephos probe slab bad.csv --seed 18446744073709551616
