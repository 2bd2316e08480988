# SPDX-License-Identifier: Apache-2.0
# Times with and without a zone: where the sun stands, said with each frame, and warned of once.
cat >local.yaml <<END
version: 1
place: {latitude: 44.27 deg, longitude: -71.3 deg}
camera: {resolution: [32, 18]}
sun: {time: 2026-06-21T06:40}
output: {preview: local_time.png}
END
sun() { grep -o 'sun at.*'; }
nephos render local.yaml -q --samples 1 | sun
for zone in Z -0400 ' America/New_York' ' Asia/Kathmandu'; do
  nephos render local.yaml -q --samples 1 -o a.exr --set "sun.time=2026-06-21T10:40$zone" --set airglow={} | sun
done
nephos render local.yaml -q --samples 1 --json -o a.exr --set "sun.time=2026-06-21 06:40 America/New_York" |
  grep -o '"sun_.*_deg": [0-9.]*'

# Once for a scene, not for a frame; of a track too; and of what takes no picture.
echo moving >&2
nephos render local.yaml -q --samples 1 --frames 1,61 -o "a.#.exr" --set sun.frame_time=60 --set airglow={} | sun
nephos render local.yaml -q --samples 1 --frames 1,61 -o "b.#.exr" --set airglow={} \
  --set "animate={sun.time: [[1, 2026-06-21T06:40], [61, 2026-06-21T07:40Z]]}" | sun
nephos render local.yaml --explain >/dev/null
nephos check local.yaml || true

# The poles, the date line, and a place that is missing.
echo places >&2
nephos render local.yaml -q --samples 1 -o a.exr --set "sun.time=2026-06-21 12:00 Antarctica/South_Pole" \
  --set place.latitude=-90 --set moon={} | sun
nephos render local.yaml -q --samples 1 -o a.exr --set "sun.time=2026-06-21T12:00" --set place.latitude=90 \
  --set place.longitude=180 | sun
nephos render local.yaml -q --samples 1 -o a.exr --set "sun.time=2026-06-21T00:10" --set place.latitude=0 \
  --set place.longitude=-180 | sun
sed '/place/d; s/06:40/06:40Z/' local.yaml >nowhere.yaml
nephos render nowhere.yaml -q || echo "exit $?"
nephos info nowhere.yaml --set "place={latitude: 42, longitude: -71}" | grep -c sun.time

# The limit of 6° is that of the place, however far below it a high camera sees the horizon.
echo twilight >&2
for height in 0 10km; do
  for elevation in -5.9 -6.1; do
    nephos render local.yaml -q --samples 1 -o a.exr --set "sun={elevation: $elevation deg}" \
      --set "camera.position=[0, 0, $height]" | sun
  done
done

# Nothing is to be said where fire, moon or an even sky lights the night; nor of a dark preview that is kept dark.
echo nights >&2
night() { nephos render local.yaml -q --samples 1 -o a.exr --set sun.time=2026-06-21T06:40Z "$@" | sun; }
night
night --set stars={}
night --set environment.radiance=0.1
night --set environment.planet=none
nephos render local.yaml -q --samples 1 -o a.png --set sun.time=2026-06-21T06:40Z --set stars={} \
  --set output.exposure=0 | sun

# Refusals have the place of the key.
echo refusals >&2
for time in "2026-03-08 02:30 America/New_York" "2026-11-01T01:30 America/New_York" "2026-06-21 06:40 Europa/Zurich" \
  "2026-06-21 06:40 ../../etc/passwd" "2026-06-21 06:40 EDT" "21.6.2026 06:40"; do
  sed "s|2026-06-21T06:40|$time|" local.yaml >wrong.yaml
  nephos info wrong.yaml || echo "exit $?"
done
TZDIR=$PWD/none nephos info local.yaml --set "sun.time=2026-06-21 06:40 Europe/Zurich" 2>&1 | sed "s|$PWD|FOLDER|" >&2
TZ=Asia/Tokyo nephos info local.yaml --set "sun.time=2026-06-21 06:40 Europe/Zurich" | grep sun.time
