# SPDX-License-Identifier: Apache-2.0
# No error is reached by no samples: a target of 0 is refused, not passed over, and so is what is no target.
try() { if nephos "$@"; then exit 99; else [ $? -eq 2 ]; fi; }
printf 'version: 1\ncamera: {resolution: [4, 2]}\n' >scene.yaml
printf 'quantity,g,albedo,tau,mu0\nflux,0,1,0,1\n' >cases.csv
for target in 0 -0.1 nan soon; do
  try render scene.yaml -q --target-error $target
  try probe slab cases.csv -q --target-error $target
done
ls
try probe sky cases.csv -q --target-error 0.1
nephos probe slab cases.csv -q --paths 64 --target-error 0.5
