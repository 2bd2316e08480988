/* SPDX-License-Identifier: Apache-2.0 */
/* Light of the night through the air.
 *
 * Stars, and what a map has of them, lose what the air scatters. Airglow, all over the sky, gets most of that back from
 * its other parts: its effective depth is f times that of the zenith, f = 1.669·log₁₀X − 0.146 at the air mass X (Noll
 * et al. 2012, "An atmospheric radiation model for Cerro Paranal", A&A 543, equation 24), slightly less than nothing
 * at the zenith and 2.5 at the horizon, where the direct light is dimmed 38-fold in depth. Rays of larger air masses,
 * which pass the air by from above, take their own depth.
 */
#include "world/world.h"

#include "core/units.h"

static np_spectrum sample_map(const np_night *night, np_vec3 direction) {
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

/* Effective depth of airglow over the zenith depth. Seen from the ground the air mass is at most 38, of low haze 90. */
static float compute_airglow_factor(float mass) {
  static const float most = 120.0f;
  const float regained = 1.669f * log10f(np_clampf(mass, 1.0f, most)) - 0.146f;
  return np_mixf(regained, mass, np_smoothstepf((mass - most) / most));
}

static float dim_airglow(float upward, float along) {
  const float least = 1e-30f, zenith_depth = -logf(np_maxf(upward, least)), depth = -logf(np_maxf(along, least));
  if (zenith_depth <= 1e-6f) return along;
  return expf(-zenith_depth * compute_airglow_factor(depth / zenith_depth));
}

/* Radiance of airglow through the air, with the airglow that the air scatters into the view. */
static np_spectrum compute_airglow(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                                   np_vec3 direction, np_spectrum transmittance) {
  np_spectrum airglow = np_airglow_radiance(&night->airglow, origin, direction);
  if (!atmosphere) return airglow;
  const np_vec3 up = np_zenith(origin, np_atmosphere_get_planet_radius(atmosphere));
  const np_spectrum upward = np_atmosphere_transmittance_to_space(atmosphere, origin, up);
  for (int b = 0; b < NP_BAND_COUNT; b++) airglow.band[b] *= dim_airglow(upward.band[b], transmittance.band[b]);
  return airglow;
}

np_spectrum np_night_radiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                              np_vec3 direction) {
  const np_spectrum none = np_spectrum_grey(0.0f);
  if (!night->has_airglow && !night->map) return none;
  np_spectrum transmittance = np_spectrum_grey(1.0f), radiance = none;
  if (atmosphere) transmittance = np_atmosphere_transmittance_to_space(atmosphere, origin, direction);
  if (np_spectrum_is_zero(transmittance)) return none;
  if (night->map) radiance = np_spectrum_multiply(sample_map(night, direction), transmittance);
  if (!night->has_airglow) return radiance;
  return np_spectrum_add(radiance, compute_airglow(night, atmosphere, origin, direction, transmittance));
}

np_spectrum np_night_compute_irradiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin) {
  enum { RINGS = 24, AZIMUTHS = 48 };
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < RINGS; i++) /* rings are even in sin², whose differential has the weight of the cosine */
    for (int k = 0; k < AZIMUTHS; k++) {
      const double s2 = (i + 0.5) / RINGS, s = sqrt(s2), turn = 2.0 * NP_PI * (k + 0.5) / AZIMUTHS;
      const np_vec3 d = np_vec3_make((float)(s * cos(turn)), (float)(s * sin(turn)), (float)sqrt(1.0 - s2));
      sum = np_spectrum_add(sum, np_night_radiance(night, atmosphere, origin, d));
    }
  return np_spectrum_scale(sum, NP_PI_F / (RINGS * AZIMUTHS));
}
