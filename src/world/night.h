/* SPDX-License-Identifier: Apache-2.0 */
/* Lights of the sky beside the view's own: the moon's disk, airglow, a map of the stars. */
#ifndef NP_WORLD_NIGHT_H
#define NP_WORLD_NIGHT_H

#include "atmosphere/airglow.h"
#include "atmosphere/atmosphere_private.h"
#include "atmosphere/disk.h"

typedef struct np_night {
  np_disk moon; /* of versine 0: none */
  bool has_airglow;
  np_airglow airglow;
  const np_sphere_map *map;                       /* of the stars; NULL: none; borrowed */
  float map_weight[NP_BAND_COUNT][NP_BAND_COUNT]; /* from its channels, W m⁻² sr⁻¹ nm⁻¹ for 1, to the packet's bands */
  np_celestial_turn turn;                         /* of the stars */
  np_spectrum ground_irradiance;                  /* of the two on level ground: see np_night_compute_irradiance */
} np_night;

/* Radiance of airglow and map along a ray that meets no ground, dimmed by the air. `atmosphere` NULL: none. */
np_spectrum np_night_radiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin,
                              np_vec3 direction);

/* Its integral over the upper half of the sky at a point. */
np_spectrum np_night_compute_irradiance(const np_night *night, const neph_atmosphere *atmosphere, np_dvec3 origin);

#endif
