/* SPDX-License-Identifier: Apache-2.0 */
/* Light of the clouds on their surroundings, gathered from the solution of the multiple scattering. */
#ifndef NP_CACHES_CLOUD_LIGHT_H
#define NP_CACHES_CLOUD_LIGHT_H

#include "caches/lit_air.h"

typedef struct np_cloud_light {
  np_ground_light ground;
  np_lit_air air; /* empty where there is no air */
} np_cloud_light;

/* Computes both. On failure `*out` is empty. */
neph_result np_cloud_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                 np_cloud_light *out);
void np_cloud_light_clear(np_cloud_light *light);

/* Save the light on disk, and load it. False: the entry is too short. */
void np_cloud_light_save(const np_cloud_light *light, np_cache_entry *entry);
bool np_cloud_light_load(neph_context *context, np_cache_entry *entry, np_cloud_light *out);

/* Parts of a light that may be NULL; NULL where there is none. */
static inline const np_ground_light *np_cloud_light_get_ground(const np_cloud_light *light) {
  return light ? &light->ground : NULL;
}
static inline const np_lit_air *np_cloud_light_get_air(const np_cloud_light *light) {
  return light && light->air.points ? &light->air : NULL;
}

#endif
