# SPDX-License-Identifier: Apache-2.0
# A key, a group of keys, the beginning of keys; an old name; what is none.
nephos schema camera.fov
nephos schema 'clouds[3].phase.two_lobe'
nephos schema output.p
nephos schema render.splitting
nephos schema render.sun_depth --json
nephos schema camera --json | grep '"key"'
for key in camera.fow camra nothing.at.all 'clouds[0].phase.hgg' camera.fov.x; do
  if nephos schema "$key"; then exit 99; else [ $? -eq 2 ]; fi
done
