/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/cloud_light.h"

#include "core/units.h"

typedef struct air_job {
  const np_cloud_gather *gather;
  const np_ground_rays *rays;
  np_cloud_light *light;
} air_job;

/* Adds the change of the air's light by the clouds to the light that reaches a point from the sky. */
static void add_air(const air_job *job, size_t point) {
  np_ground_light *ground = &job->light->ground;
  const np_dvec3 place = np_ground_light_get_place(ground, job->gather, point);
  np_spectrum clear = np_spectrum_grey(0.0f), change = clear;
  for (unsigned i = 0; i < NP_GROUND_DIRECTIONS; i++) {
    const np_ground_direction *d = &job->rays->directions[i];
    const np_gather_ray *ray = &job->rays->at[point * NP_GROUND_DIRECTIONS + i];
    if (isfinite(ray->end_m)) continue;
    clear = np_spectrum_add(clear, d->air.clear);
    change =
        np_spectrum_add(change, np_lit_air_along(&job->light->air, &d->air, d->gather.towards, place, ray, d->offset));
  }
  np_ground_light_value *value = &ground->points[point];
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    if (change.band[b] > 0.0f)
      value->added.band[b] += change.band[b] * NP_PI_F / NP_GROUND_DIRECTIONS;
    else if (clear.band[b] > 0.0f)
      value->open.band[b] = fmaxf(0.0f, value->open.band[b] + change.band[b] / clear.band[b]);
  }
}

static neph_result add_air_to_points(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t n = begin; n < end; n++) add_air(user, n);
  return NEPH_OK;
}

static neph_result light_air(neph_context *context, air_job *job, np_monitor *monitor) {
  neph_result result = np_lit_air_build(context, job->gather, &job->light->ground, monitor, &job->light->air);
  if (result) return result;
  const size_t count = np_ground_light_count_points(&job->light->ground);
  return np_parallel_for(context, monitor, count, 8, add_air_to_points, job);
}

neph_result np_cloud_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                 np_cloud_light *out) {
  *out = (np_cloud_light){0};
  np_ground_rays rays = {0};
  np_monitor_set_range(monitor, 0.0, 0.5);
  neph_result result = np_ground_light_build(context, gather, monitor, &out->ground, &rays);
  np_monitor_set_range(monitor, 0.5, 1.0);
  air_job job = {gather, &rays, out};
  if (!result && gather->world->atmosphere) result = light_air(context, &job, monitor);
  np_ground_rays_clear(context, &rays);
  if (result) np_cloud_light_clear(out);
  return result;
}

void np_cloud_light_clear(np_cloud_light *light) {
  if (light->air.context) np_lit_air_clear(&light->air);
  if (light->ground.context) np_ground_light_clear(&light->ground);
}

void np_cloud_light_save(const np_cloud_light *light, np_cache_entry *entry) {
  const uint64_t has_air = light->air.points != NULL;
  np_ground_light_save(&light->ground, entry);
  NP_CACHE_WRITE(entry, has_air);
  if (has_air) np_lit_air_save(&light->air, entry);
}

bool np_cloud_light_load(neph_context *context, np_cache_entry *entry, np_cloud_light *out) {
  uint64_t has_air;
  *out = (np_cloud_light){0};
  bool is_read = np_ground_light_load(context, entry, &out->ground) && NP_CACHE_READ(entry, has_air) &&
                 np_cache_read_check(entry, has_air <= 1) && (!has_air || np_lit_air_load(context, entry, &out->air));
  if (!is_read) np_cloud_light_clear(out);
  return is_read;
}
