/* SPDX-License-Identifier: Apache-2.0 */
/* Points that may be in cloud, compacted after each test, so that noise is evaluated only where it can decide.
 * Positions are in the frame of the air, which drifts, turns over, and in a slab is sheared. */
#ifndef NP_CLOUD_AIR_POINTS_H
#define NP_CLOUD_AIR_POINTS_H

#include "cloud/cloud_model.h"

/* State of a column at a height. */
typedef struct np_air_state {
  float depth, share; /* `share`: height above the base over the column's thickness */
  float relief;       /* factor on the noise's amplitude */
  float ice;          /* weight of the anvil, 0 to 1 */
} np_air_state;

typedef struct np_air_points {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
  np_air_state state[NP_CLOUD_BLOCK]; /* state in the cloud; rain does not use it */
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} np_air_points;

/* Whether a point has the column of the point before it. */
static inline bool np_air_is_same_column(const np_cloud_model *model, const np_cloud_points *points, size_t i) {
  return i > 0 && !model->wind.has_shift && points->x_m[i] == points->x_m[i - 1] &&
         points->y_m[i] == points->y_m[i - 1];
}

/* Scales positions to cells of a lattice, which rises by `turnover` cells: billows roll upwards and are replaced. */
static inline np_noise_points np_air_points_scale(np_air_points *w, float frequency_per_m, float turnover) {
  for (size_t i = 0; i < w->count; i++) {
    w->sx[i] = w->x_m[i] * frequency_per_m;
    w->sy[i] = w->y_m[i] * frequency_per_m;
    w->sz[i] = w->height_m[i] * frequency_per_m - turnover;
  }
  return (np_noise_points){w->count, w->sx, w->sy, w->sz};
}

/* Displaces points by divergence-free noise: more at the turbulent base than at the firm tops. */
void np_air_points_displace(const np_cloud_model *model, np_air_points *w);

/* Sets up the displacement noise: size of its eddies, and displacement at turbulence 1, in largest billows. */
void np_air_points_set_curl(np_cloud_model *model, float size, float reach);

/* Sets the depth over which extinction rises, from the slope at outlines. */
void np_air_points_set_edge(np_cloud_model *model);

#endif
