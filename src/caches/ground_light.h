/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds: their opacity to the sky, and the light that they scatter down.
 *
 * Found once at the points of a level grid over the clouds and around them, each at the ground's height, and
 * interpolated; towards the grid's rim it becomes that of a clear sky. The light of fires goes on beyond, as the
 * inverse square of the distance. Under clouds that repeat without end the grid is that of one period. Depends on all
 * that the multiple scattering depends on, and on the ground's height; not on the camera.
 */
#ifndef NP_CACHES_GROUND_LIGHT_H
#define NP_CACHES_GROUND_LIGHT_H

#include "caches/gather_air.h"
#include "volume/instance_period.h"

/* Irradiance of level ground at one place from the irradiance E of a clear sky: `open`·E + `added`. */
typedef struct np_ground_light_value {
  np_spectrum open;    /* transmitted share of the sky's light */
  np_spectrum added;   /* irradiance from the clouds, W m⁻² nm⁻¹ */
  np_spectrum emitted; /* irradiance from emission, not scattered, for the air's light: integrators sample their own */
  np_spectrum linear[2]; /* first moments ∫ L d dω along x and y of the clouds' light and of their change of the sky's,
                          W m⁻² nm⁻¹ */
} np_ground_light_value;

/* Irradiance from the clouds on a slope, of whose sky it sees a share: the even part, and that of the first harmonics
 * (a half of the linear along its normal). */
np_spectrum np_ground_light_add_slope(const np_ground_light_value *value, np_vec3 normal, float share);

typedef struct np_ground_light {
  neph_context *context; /* borrowed */
  int32_t size[2];       /* points */
  bool is_of_fire;
  double origin_m[2], spacing_m;
  np_light_period period[2];     /* along x and y, from the first point on; a length of 0: light does not repeat */
  np_transport_fold fold;        /* tiles of which the points cover one; a period of 0: none */
  np_ground_light_value *points; /* x fastest */
  float fade[NP_INSTANCES_MAX];  /* share of each cloud's optical depth that attenuates sunlight: its forward peak
                                    counts as unscattered */
} np_ground_light;

enum { NP_GROUND_DIRECTIONS = 96 };

/* A direction of the cosine-weighted set, the clear air along it, and the shift of places along its rays. */
typedef struct np_ground_direction {
  np_cloud_direction gather;
  np_gather_air air;
  double offset;
} np_ground_direction;

/* The rays of a build. */
typedef struct np_ground_rays {
  np_ground_direction *directions; /* NP_GROUND_DIRECTIONS */
  np_gather_ray *at;               /* [point][direction] */
} np_ground_rays;

/* Computes the cache, with the shadows of clouds in the air but without the light that clouds add to it. On failure
 * `*out` is empty; the caller clears `*out_rays` in any case. */
neph_result np_ground_light_build(neph_context *context, const np_cloud_gather *gather, np_monitor *monitor,
                                  np_ground_light *out, np_ground_rays *out_rays);
void np_ground_rays_clear(neph_context *context, np_ground_rays *rays);

static inline size_t np_ground_light_count_points(const np_ground_light *cache) {
  return (size_t)cache->size[0] * (size_t)cache->size[1];
}

/* Place of a point on the ground. */
np_dvec3 np_ground_light_get_place(const np_ground_light *cache, const np_cloud_gather *gather, size_t point);

void np_ground_light_clear(np_ground_light *cache);

/* Save the cache on disk, and load it. False: the entry is too short. */
void np_ground_light_save(const np_ground_light *cache, np_cache_entry *entry);
bool np_ground_light_load(neph_context *context, np_cache_entry *entry, np_ground_light *out);

np_ground_light_value np_ground_light_get(const np_ground_light *cache, np_dvec3 position);

#endif
