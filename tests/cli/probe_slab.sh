# SPDX-License-Identifier: Apache-2.0
# Fluxes through, back and absorbed; a slab of depth 0 answers without noise.
cat >cases.csv <<END
# a comment
quantity,g,albedo,tau,mu0,mu_view,phi_deg,source
flux,0.85,1,0,diffuse,,,"one, and ""two"""
radiance_top_up,0.85,1,0,0.5,0.7,30,
flux,0,1,1e6,1,,,too deep
END
nephos probe slab cases.csv --paths 64 --progress none
nephos probe slab - -q --integrator march --paths 64 -o out.csv <cases.csv
head -n 3 out.csv
ls
# Nothing comes through to so few paths unless they are guided.
printf 'quantity,g,albedo,tau,mu0\nflux,0,0.9,64,1\n' >deep.csv
nephos probe slab deep.csv -q --path-guiding none --paths 64 | cut -d, -f7,9
nephos probe slab deep.csv -q --paths 1024 | cut -d, -f7,9 | grep -c inf || true
