/* SPDX-License-Identifier: Apache-2.0 */
/* Copies of the light of clouds on the air on disk. */
#include "caches/lit_air.h"
#include "caches/tile_points.h"

void np_lit_air_save(const np_lit_air *light, np_cache_entry *entry) {
  const uint64_t is_of_fire = light->is_of_fire;
  NP_CACHE_WRITE(entry, light->size);
  NP_CACHE_WRITE(entry, is_of_fire);
  NP_CACHE_WRITE(entry, light->fire);
  NP_CACHE_WRITE(entry, light->fall);
  NP_CACHE_WRITE(entry, light->origin_m);
  NP_CACHE_WRITE(entry, light->spacing_m);
  NP_CACHE_WRITE(entry, light->period);
  NP_CACHE_WRITE(entry, light->fold);
  NP_CACHE_WRITE(entry, light->level_m);
  NP_CACHE_WRITE(entry, light->clear);
  np_cache_write(entry, light->points, np_lit_air_count_points(light) * sizeof *light->points);
}

/* Whether a loaded lattice is valid: a look-up needs two points along each axis. */
static bool is_sound(const np_lit_air *light) {
  for (int n = 0; n < 2; n++)
    if (light->size[n] < 2 || light->size[n] > NP_LIT_AIR_POINTS_MAX + 1 || !isfinite(light->origin_m[n]) ||
        !np_light_period_is_sound(light->period[n]))
      return false;
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++)
    if (!isfinite(light->level_m[k]) || (k > 0 && !(light->level_m[k] > light->level_m[k - 1]))) return false;
  return np_tile_is_sound(&light->fold) && light->spacing_m > 0.0 && isfinite(light->spacing_m);
}

/* Whether a fire's middle lies in the lattice, from where a way beyond it leaves it. */
static bool has_fire_inside(const np_lit_air *a) {
  const double at[2] = {a->fire.x, a->fire.y};
  for (int n = 0; n < 2; n++)
    if (!(at[n] > a->origin_m[n] && at[n] < a->origin_m[n] + a->spacing_m * (a->size[n] - 1))) return false;
  return a->fire.z >= a->level_m[0] && a->fire.z <= a->level_m[NP_LIT_AIR_LEVELS - 1];
}

bool np_lit_air_load(neph_context *context, np_cache_entry *entry, np_lit_air *out) {
  uint64_t is_of_fire;
  *out = (np_lit_air){.context = context};
  if (!NP_CACHE_READ(entry, out->size) || !NP_CACHE_READ(entry, is_of_fire) || !NP_CACHE_READ(entry, out->fire) ||
      !NP_CACHE_READ(entry, out->fall) || !NP_CACHE_READ(entry, out->origin_m) ||
      !NP_CACHE_READ(entry, out->spacing_m) || !NP_CACHE_READ(entry, out->period) || !NP_CACHE_READ(entry, out->fold) ||
      !NP_CACHE_READ(entry, out->level_m) || !NP_CACHE_READ(entry, out->clear))
    return false;
  out->is_of_fire = is_of_fire;
  const bool is_fire_sound = np_cache_are_finite(out->fall.band, NP_BAND_COUNT) && has_fire_inside(out);
  if (!np_cache_read_check(entry, is_of_fire <= 1 && is_sound(out) && (!is_of_fire || is_fire_sound))) return false;
  out->points = np_cache_read_block(entry, np_lit_air_count_points(out), sizeof *out->points);
  return out->points;
}
