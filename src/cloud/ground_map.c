/* SPDX-License-Identifier: Apache-2.0 */
/* The ground below a field: a caller's heights in texels of the weather map, and its effect on clouds. */
#include "cloud/ground_map.h"

#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "core/alloc.h"
#include "core/hash.h"
#include "core/math.h"
#include "core/text.h"

static const float cover_height =
    1.6f; /* height difference of the landscape between low and high ground, at a cover of 1 */
static const float lift_max = 0.9f; /* relative to the thickness */

enum { ID_EDGE = 65 }; /* heights along each side of a field that are hashed to identify the ground */

bool np_cloud_desc_has_ground(const neph_cloud_desc *desc) {
  if (!desc->ground_height && !desc->ground_id) return false;
  return np_cloud_kind_get(desc->model)->landscape.has_ground || desc->ground_lift > 0 || desc->ground_cover != 0;
}

/* Height above the base altitude. */
static float get_height_m(const neph_cloud_desc *desc, double x_m, double y_m) {
  const double height_m = desc->ground_height(desc->ground_user, desc->center_m[0] + x_m, desc->center_m[1] + y_m);
  return (float)(height_m - desc->base_altitude_m);
}

typedef struct ground_job {
  const neph_cloud_desc *desc;
  np_weather_map *map;
} ground_job;

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const ground_job *job = user;
  const np_weather_map *map = job->map;
  (void)thread;
  for (size_t row = begin; row < end; row++)
    for (int32_t i = 0; i < map->size[0]; i++)
      map->ground_m[row * (size_t)map->size[0] + (size_t)i] =
          get_height_m(job->desc, (double)(map->origin_m[0] + (float)i * map->step_m),
                       (double)(map->origin_m[1] + (float)row * map->step_m));
  return NEPH_OK;
}

static neph_result check_heights(neph_context *context, const neph_cloud_desc *desc, np_weather_map *map) {
  const size_t count = (size_t)map->size[0] * (size_t)map->size[1];
  map->ground_low_m = INFINITY;
  map->ground_high_m = -INFINITY;
  for (size_t i = 0; i < count; i++) {
    const float height_m = map->ground_m[i];
    if (!(fabsf(height_m) <= 2e5f))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s: ground_height gives %g m at a position in the field, must be within 100 km of 0",
                     np_cloud_desc_name(desc), (double)height_m + desc->base_altitude_m);
    map->ground_low_m = fminf(map->ground_low_m, height_m);
    map->ground_high_m = fmaxf(map->ground_high_m, height_m);
  }
  return NEPH_OK;
}

neph_result np_ground_map_fill(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                               np_weather_map *map) {
  if (!np_cloud_desc_has_ground(desc)) return NEPH_OK;
  if (!desc->ground_height)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: was shaped by a ground that is not given here, must come with ground_height",
                   np_cloud_desc_name(desc));
  ground_job job = {desc, map};
  map->ground_m = np_alloc(context, (size_t)map->size[0] * (size_t)map->size[1], sizeof *map->ground_m);
  if (!map->ground_m) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(context, monitor, (size_t)map->size[1], 4, fill_rows, &job);
  return result ? result : check_heights(context, desc, map);
}

/* Adds the effect of the ground; a flat ground has none. */
void np_ground_map_cover(const neph_cloud_desc *desc, np_weather_map *map) {
  const size_t count = (size_t)map->size[0] * (size_t)map->size[1];
  const float range_m = map->ground_high_m - map->ground_low_m;
  if (!map->ground_m || desc->ground_cover == 0 || !(range_m > 0)) return;
  const float strength = (float)desc->ground_cover * cover_height / range_m;
  const float middle_m = 0.5f * (map->ground_low_m + map->ground_high_m);
  for (size_t i = 0; i < count; i++) {
    const float raised = strength * (map->ground_m[i] - middle_m);
    map->values[i] += raised;
    if (map->anvils) map->anvils[i] += raised;
  }
}

void np_ground_map_lift(const neph_cloud_desc *desc, np_weather_map *map) {
  float *base = map->planes[NEPH_CLOUD_MAP_BASE];
  const size_t count = (size_t)map->size[0] * (size_t)map->size[1];
  if (!map->ground_m || !base || !(desc->ground_lift > 0)) return;
  const float share = (float)(desc->ground_lift / desc->thickness_m);
  for (size_t i = 0; i < count; i++)
    base[i] = np_minf(base[i] + share * (map->ground_m[i] - map->ground_low_m), lift_max);
}

neph_result np_ground_map_identify(neph_context *context, const neph_cloud_desc *desc, char out_id[33]) {
  if (desc->ground_id) {
    np_print(out_id, 33, "%s", desc->ground_id);
    return NEPH_OK;
  }
  np_hash *hash = np_hash_create(context);
  for (int i = 0; i < ID_EDGE; i++)
    for (int j = 0; j < ID_EDGE; j++) {
      const float height_m = get_height_m(desc, desc->extent_m[0] * ((double)i / (ID_EDGE - 1) - 0.5),
                                          desc->extent_m[1] * ((double)j / (ID_EDGE - 1) - 0.5));
      NP_HASH_ADD(hash, height_m);
    }
  return np_hash_finish(hash, out_id);
}
