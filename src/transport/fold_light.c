/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/fold_light.h"

#include "core/units.h"

/* Most that a gain may be: in twilight it would grow without bound. */
static const float gain_max = 16.0f;

/* Irradiance on level ground where the sun stands higher by an angle than at the origin: light that clouds take, per
 * area, whatever their shape. */
static np_spectrum compute_irradiance(const np_world *world, const np_transport_fold *fold, double angle_rad) {
  const np_dvec3 sun = np_vec3_to_double(world->to_sun);
  const double level = hypot(sun.x, sun.y), across = fold->pitch_radius_m * sin(angle_rad);
  const double half = sin(0.5 * angle_rad);
  const double east = level > 1e-9 ? sun.x / level : 1.0, north = level > 1e-9 ? sun.y / level : 0.0;
  const double altitude_m = fold->pitch_radius_m - fold->planet_radius_m;
  const np_dvec3 place =
      np_dvec3_make(across * east, across * north, altitude_m - 2.0 * fold->pitch_radius_m * half * half);
  const np_vec3 zenith = np_zenith(place, fold->planet_radius_m);
  const np_ground_hit hit = {.position = place, .normal = zenith};
  const float cosine = np_maxf(np_vec3_dot(zenith, world->to_sun), 0.0f);
  return np_spectrum_add_scaled(np_world_level_irradiance(world, &hit), cosine,
                                np_world_sunlight(world, place, world->to_sun));
}

void np_fold_light_fill(const np_world *world, const np_transport_fold *fold, np_fold_light *out) {
  const double height = asin(np_clamp((double)world->to_sun.z, -1.0, 1.0));
  const double reach = fmin(fold->range_m / fold->pitch_radius_m, 0.5 * NP_PI);
  const double low = sin(fmax(height - reach, -0.5 * NP_PI)), high = sin(fmin(height + reach, 0.5 * NP_PI));
  const np_spectrum own = compute_irradiance(world, fold, 0.0);
  *out = (np_fold_light){.to_sun = {world->to_sun.x, world->to_sun.y, world->to_sun.z},
                         .cosine_low = (float)low,
                         .nodes_per_cosine = high > low ? (float)((NP_FOLD_GAINS - 1) / (high - low)) : 0.0f};
  for (int n = 0; n < NP_FOLD_GAINS; n++) {
    const double cosine = low + (high - low) * n / (NP_FOLD_GAINS - 1);
    const np_spectrum there = compute_irradiance(world, fold, asin(np_clamp(cosine, -1.0, 1.0)) - height);
    for (int b = 0; b < NP_BAND_COUNT; b++)
      out->gain[n][b] = own.band[b] > 0.0f ? np_minf(there.band[b] / own.band[b], gain_max) : 1.0f;
  }
}
