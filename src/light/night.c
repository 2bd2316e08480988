/* SPDX-License-Identifier: Apache-2.0 */
#include "light/night.h"

#include "core/units.h"

static np_spectrum look_up_map(const np_night *night, np_vec3 direction) {
  const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  float e[3];
  for (int i = 0; i < 3; i++)
    e[i] = (float)(night->turn.row[0][i] * d[0] + night->turn.row[1][i] * d[1] + night->turn.row[2][i] * d[2]);
  const np_spectrum texel = np_sphere_map_lookup(night->map, e[0], e[1], e[2]);
  np_spectrum out = np_spectrum_grey(0.0f);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    for (int c = 0; c < NP_BAND_COUNT; c++) out.band[b] += night->map_weight[b][c] * texel.band[c];
  return out;
}

np_spectrum np_night_radiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                              np_vec3 direction) {
  np_spectrum radiance = np_spectrum_grey(0.0f);
  if (night->has_airglow) radiance = np_airglow_radiance(&night->airglow, origin, direction);
  if (night->map) radiance = np_spectrum_add(radiance, look_up_map(night, direction));
  if (!atmosphere || np_spectrum_is_zero(radiance)) return radiance;
  return np_spectrum_multiply(radiance, np_atmosphere_transmittance_to_space(atmosphere, origin, direction));
}

np_spectrum np_night_find_irradiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin) {
  enum { RINGS = 24, TURNS = 48 };
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < RINGS; i++) /* even in the squared sine, of which the cosine's weight is the differential */
    for (int k = 0; k < TURNS; k++) {
      const double s2 = (i + 0.5) / RINGS, s = sqrt(s2), turn = 2.0 * NP_PI * (k + 0.5) / TURNS;
      const np_vec3 d = np_vec3_make((float)(s * cos(turn)), (float)(s * sin(turn)), (float)sqrt(1.0 - s2));
      sum = np_spectrum_add(sum, np_night_radiance(night, atmosphere, origin, d));
    }
  return np_spectrum_scale(sum, NP_PI_F / (RINGS * TURNS));
}
