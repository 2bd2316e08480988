/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/fire_rays.h"

#include "core/random.h"

/* Density per solid angle of the direction to a point of the clouds' box. */
static double compute_box_density(const np_cloud_gather *g, np_dvec3 position, np_vec3 towards) {
  const np_dvec3 size = np_dvec3_subtract(g->bounds_max, g->bounds_min);
  double begin, end;
  if (!np_cloud_gather_clip(g, position, towards, &begin, &end)) return 0.0;
  return (end * end * end - begin * begin * begin) / (3.0 * size.x * size.y * size.z);
}

float np_fire_rays_weigh(const np_fire_rays *rays, np_dvec3 position, np_vec3 towards, double even) {
  const np_emission *emission = rays->gather->world->emission;
  if (!emission) return 1.0f;
  const double to_emission = rays->to_emission * (double)np_emission_direction_density(emission, position, towards);
  const double to_box = rays->to_box * compute_box_density(rays->gather, position, towards);
  return (float)(even / (even + to_emission + to_box));
}

/* The i-th point of a set that fills the clouds' box evenly (Roberts 2018, "The Unreasonable Effectiveness of
 * Quasirandom Sequences"). */
static np_dvec3 get_box_point(const np_cloud_gather *g, unsigned i) {
  const np_dvec3 low = g->bounds_min, size = np_dvec3_subtract(g->bounds_max, low);
  return np_dvec3_make(low.x + size.x * fmod(0.5 + 0.8191725133961645 * i, 1.0),
                       low.y + size.y * fmod(0.5 + 0.6710436067037893 * i, 1.0),
                       low.z + size.z * fmod(0.5 + 0.5497004779019703 * i, 1.0));
}

bool np_fire_rays_aim(const np_fire_rays *rays, np_dvec3 position, unsigned i, np_vec3 *out_towards) {
  const np_emission *emission = rays->gather->world->emission;
  const unsigned count = rays->to_emission;
  np_dvec3 place = position;
  *out_towards = np_vec3_make(0.0f, 0.0f, 0.0f);
  if (!emission || i >= count + rays->to_box) return false;
  np_random random = np_random_start(0, 0, i, 0, 0);
  if (i >= count)
    place = get_box_point(rays->gather, i - count);
  else if (!np_emission_draw(emission, (i + 0.5) / count, &random, &place))
    return true;
  const np_vec3 away = np_dvec3_to_float(np_dvec3_subtract(place, position));
  if (np_vec3_length(away) > 0.0f) *out_towards = np_vec3_normalize(away);
  return true;
}
