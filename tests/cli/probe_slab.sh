# SPDX-License-Identifier: Apache-2.0
# What passes through, what is added, where it goes; a slab of depth 0 answers without noise.
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
