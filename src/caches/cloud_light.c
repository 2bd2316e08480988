/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/cloud_light.h"

neph_result np_cloud_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                 np_cloud_light *out) {
  *out = (np_cloud_light){0};
  np_monitor_set_range(monitor, 0.0, 0.5);
  neph_result result = np_ground_light_build(context, gather, monitor, &out->ground);
  np_monitor_set_range(monitor, 0.5, 1.0);
  if (!result && gather->world->atmosphere)
    result = np_lit_air_build(context, gather, &out->ground, monitor, &out->air);
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
