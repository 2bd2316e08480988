/* SPDX-License-Identifier: Apache-2.0 */
/* Light of equal tiles of a sphere, of which one is solved for: the sun stands higher over some of them. */
#ifndef NP_TRANSPORT_FOLD_LIGHT_H
#define NP_TRANSPORT_FOLD_LIGHT_H

#include "transport/transport_fold.h"
#include "world/world.h"

enum { NP_FOLD_GAINS = 33 };

/* Irradiance of sun and sky on level ground over that at the origin, by the cosine of the sun's zenith angle. */
typedef struct np_fold_light {
  float to_sun[3], cosine_low, nodes_per_cosine;
  float gain[NP_FOLD_GAINS][NP_BAND_COUNT];
} np_fold_light;

void np_fold_light_fill(const np_world *world, const np_transport_fold *fold, np_fold_light *out);

/* Gains of a place, by bands. */
static inline void np_fold_light_get(const np_fold_light *light, const np_transport_fold *fold, np_dvec3 position,
                                     float out[NP_BAND_COUNT]) {
  const np_vec3 zenith = np_zenith(position, fold->planet_radius_m);
  const float cosine = zenith.x * light->to_sun[0] + zenith.y * light->to_sun[1] + zenith.z * light->to_sun[2];
  const float at = np_clampf((cosine - light->cosine_low) * light->nodes_per_cosine, 0.0f, NP_FOLD_GAINS - 1.001f);
  const int node = (int)at;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out[b] = light->gain[node][b] + (at - (float)node) * (light->gain[node + 1][b] - light->gain[node][b]);
}

#endif
