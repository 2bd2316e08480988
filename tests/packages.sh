# SPDX-License-Identifier: Apache-2.0
# Sourced by tests/run.sh and samples/run.sh. The one list of what nephos is built from, as Debian 12 names it.
packages='build-essential cmake ninja-build pkg-config
libopenvdb-dev libnanovdb-dev libblosc-dev zlib1g-dev libboost-dev libtbb-dev libimath-dev
libembree-dev libassimp-dev libgdal-dev libnetcdf-dev libopencolorio-dev libopenexr-dev libpng-dev
libyaml-dev libjansson-dev libxxhash-dev libnova-dev
libcmocka-dev groff-base libopenvdb-tools libnanovdb-tools python3-openvdb openimageio-tools gnuplot-nox
python3 python3-numpy python3-scipy python3-matplotlib python3-pytest tzdata python3-yaml python3-jsonschema abigail-tools
chromium chromium-driver python3-selenium'

list_missing_packages() {
  for package in $packages; do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || printf '%s ' "$package"
  done
}

# Installs what is missing, saying what; says nothing when all is in place.
install_missing_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "This is no Debian: nothing is installed. nephos needs what Debian 12 calls" $packages >&2
    return 0
  fi
  missing=$(list_missing_packages)
  [ -n "$missing" ] || return 0
  as_root=
  [ "$(id -u)" -eq 0 ] || as_root=sudo
  echo "Installing with ${as_root:+sudo }apt-get: $missing"
  $as_root apt-get update -qq &&
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
}
