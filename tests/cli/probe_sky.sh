# SPDX-License-Identifier: Apache-2.0
# Transmittance and added light; orders that do not exist; the same bits for any number of threads.
cat >cases.csv <<END
quantity,earth,max_order,h_km,mu,sun_zenith_deg,view_zenith_deg,rel_azimuth_deg,distance_km,source
transmittance_top,bruneton,0,0,1,,,,,"one, and ""two"""
transmittance_top,earth,,1,-0.5,,,,,into the ground
sky_radiance,hillaire,0,0.5,,60,30,45,,no order
direct_irradiance,hillaire,,0,,120,,,,night
ap_transmittance,earth,,2,,,70,,0,no way
END
nephos probe sky cases.csv --method march -q
head -n 1 cases.csv >traced.csv
echo 'sky_radiance,earth,3,0.5,,60,30,45,,' >>traced.csv
nephos probe sky - --method trace --paths 64 -t 1 -o one.csv -q <traced.csv
nephos probe sky traced.csv --method trace --paths 64 -t 2 --progress none >two.csv
cmp one.csv two.csv
ls
