/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/raster_place.h"

#include <math.h>

/* Earth-centred coordinates on the ellipsoid. */
static np_dvec3 get_geocentric(const np_gdal_info *info, np_geographic place) {
  const double e2 = info->flattening * (2.0 - info->flattening), sine = sin(place.latitude_rad);
  const double normal_m = info->semi_major_m / sqrt(1.0 - e2 * sine * sine),
               across_m = normal_m * cos(place.latitude_rad);
  return np_dvec3_make(across_m * cos(place.longitude_rad), across_m * sin(place.longitude_rad),
                       (1.0 - e2) * normal_m * sine);
}

np_chart_direction np_raster_place_get_direction(const np_gdal_info *info, double planet_radius_m, np_geographic origin,
                                                 np_geographic place) {
  const double sin_phi = sin(origin.latitude_rad), cos_phi = cos(origin.latitude_rad);
  const double sin_lambda = sin(origin.longitude_rad), cos_lambda = cos(origin.longitude_rad);
  const np_dvec3 d = np_dvec3_subtract(get_geocentric(info, place), get_geocentric(info, origin));
  const double east = cos_lambda * d.y - sin_lambda * d.x;
  const double north = cos_phi * d.z - sin_phi * (cos_lambda * d.x + sin_lambda * d.y);
  const double across = hypot(east, north), half = 0.5 * np_dvec3_length(d) / planet_radius_m;
  if (across == 0.0) return (np_chart_direction){0.0, 0.0};
  const double sine = sin(2.0 * asin(fmin(half, 0.7)));
  return (np_chart_direction){sine * east / across, sine * north / across};
}
