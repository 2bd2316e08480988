/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground of a landscape: the sky that hills leave open, and the light that the ground around sends back.
 *
 * Computed at the points of level grids, each on the ground, and interpolated: one over the terrain, and finer ones
 * about the eye, each with points half as far apart, down to the spacing of the terrain's own samples. A point is
 * computed when it is first needed, by whichever thread comes first, with the same bits by any. It holds the light that
 * arrives from all directions in harmonics (relief_harmonics.h), and that of the glow around the sun by its directions,
 * so that each slope about it is lit by its own half of the directions. The points are fixed in the world: they depend
 * on the terrain, the lights and the clouds; which of the finer ones there are also depends on the eye.
 */
#ifndef NP_CACHES_RELIEF_LIGHT_H
#define NP_CACHES_RELIEF_LIGHT_H

#include <stdatomic.h>

#include "caches/ground_light.h"
#include "caches/relief_sky.h"

enum {
  NP_RELIEF_POINTS_MAX = 64, /* points along each side of a grid */
  NP_RELIEF_GRIDS_MAX = 5
};

/* Light that hills take from a point. */
typedef struct np_relief_hidden {
  np_relief_irradiance sky; /* light of the clear sky but for its glow that they hide or shade, over its irradiance on
                               level ground */
  float blocked[NP_RELIEF_TERMS];        /* the same of an even sky that they hide */
  np_spectrum glow_left[NP_RELIEF_GLOW]; /* share of each direction of the glow that arrives */
} np_relief_hidden;

typedef struct np_relief_slot {
  atomic_uchar hidden_state, ground_state;
  np_relief_hidden hidden;
  np_relief_irradiance ground; /* light from hills and ground, W m⁻² nm⁻¹ */
} np_relief_slot;

/* Inputs of the points, borrowed; a picture that takes the cache over sets its own, equal ones. */
typedef struct np_relief_light_desc {
  const np_world *world;
  np_sun_optical_depths depths;
  const np_ground_light *ground_light; /* NULL: no cloud lights the ground */
  const np_dvec3 *eye;                 /* finer grids lie about it; NULL: there are none */
} np_relief_light_desc;

typedef struct np_relief_grid {
  unsigned number;
  int32_t first[2]; /* number of the first point along each axis, counted from the terrain's side */
  double origin_m[2], spacing_m[2];
  double eye_m[2];        /* place of the eye, away from which a finer grid counts the less */
  float weight;           /* the same by the eye's height */
  np_relief_slot *points; /* NP_RELIEF_POINTS_MAX along x, fastest, and along y */
} np_relief_grid;

typedef struct np_relief_light {
  neph_context *context; /* borrowed */
  np_relief_light_desc desc;
  np_relief_sky sky; /* over the terrain's middle */
  unsigned grid_count;
  np_relief_grid grids[NP_RELIEF_GRIDS_MAX]; /* the terrain's, then ever finer ones */
} np_relief_light;

/* Prepares the cache, with no point computed. On failure `*out` is empty. */
neph_result np_relief_light_build(neph_context *context, const np_relief_light_desc *desc, np_relief_light *out);
void np_relief_light_clear(np_relief_light *cache);

/* Gives the cache another picture's inputs, equal ones but for the eye, about which it lays finer grids. */
neph_result np_relief_light_set(np_relief_light *cache, const np_relief_light_desc *desc);

/* Irradiance of sky, clouds and ground around on a slope, W m⁻² nm⁻¹. Towards the grid's rim it becomes that of a slope
 * without hills, np_relief_light_get_bare. */
np_spectrum np_relief_light_get(const np_relief_light *cache, const np_ground_hit *hit);

/* Irradiance on a slope without hills: from its part of a uniform sky, and from level ground of the same albedo. */
np_spectrum np_relief_light_get_bare(const np_world *world, const np_ground_light *ground_light,
                                     const np_ground_hit *hit);

#endif
