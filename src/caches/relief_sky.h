/* SPDX-License-Identifier: Apache-2.0 */
/* The clear sky as a landscape sees it, over its irradiance on level ground.
 *
 * Harmonics to degree 2 give slopes that face away from a bright spot up to 9 % of what those that face it have. So the
 * glow around the sun is apart: it comes from a few directions, each of which hills hide or not. The rest is even
 * enough for rings and azimuths. Along each direction it is known where the air scatters sunlight for the first time,
 * since hills shade the air before the sky as well.
 */
#ifndef NP_CACHES_RELIEF_SKY_H
#define NP_CACHES_RELIEF_SKY_H

#include "atmosphere/sky_along.h"
#include "caches/relief_harmonics.h"
#include "core/random.h"
#include "world/world.h"

enum { NP_RELIEF_RINGS = 5, NP_RELIEF_SKY_AZIMUTHS = 24, NP_RELIEF_GLOW = 16, NP_RELIEF_PARTS = 8 };

/* Share of the light of the higher orders that air lacks where the sun is hidden from it: that from around the sun. */
static const float np_higher_lost = 0.5f;

/* Sines of the elevations between rings of directions: the rings are narrow near the horizon, where hills are. */
static const float np_relief_ring_edges[NP_RELIEF_RINGS + 1] = {0.0f, 0.1f, 0.2f, 0.35f, 0.55f, 1.0f};

/* Light of the air along a direction that it lacks where the sun is hidden: of its first scattering, and np_higher_lost
 * of the rest. */
typedef struct np_relief_air {
  np_spectrum share;                  /* share of the sky's light */
  double distance_m[NP_RELIEF_PARTS]; /* distances of equal parts of the first scattering */
} np_relief_air;

/* A part of a ring but for the glow. */
typedef struct np_relief_patch {
  np_spectrum radiance; /* 1/sr */
  np_relief_air air;
} np_relief_patch;

/* A direction of the glow, all of which have equal shares. */
typedef struct np_glow_direction {
  np_vec3 towards;
  np_relief_air air;
} np_glow_direction;

typedef struct np_relief_sky {
  np_relief_patch patch[NP_RELIEF_RINGS][NP_RELIEF_SKY_AZIMUTHS];
  np_relief_irradiance clear;  /* irradiance of the patches on slopes without hills */
  float even[NP_RELIEF_TERMS]; /* the same of an even sky */
  np_glow_direction glow[NP_RELIEF_GLOW];
  np_spectrum glow_share; /* irradiance of each direction on a plane that faces it; 0: there is no glow */
} np_relief_sky;

/* Cosines of a slope to the directions of the glow; 0 behind it. */
typedef struct np_glow_cosines {
  float to[NP_RELIEF_GLOW];
} np_glow_cosines;

void np_relief_sky_build(const np_world *world, np_dvec3 origin, np_relief_sky *out);

np_vec3 np_relief_make_direction(float sine, float azimuth);

const np_relief_patch *np_relief_sky_get(const np_relief_sky *sky, int ring, float azimuth);

/* Share of a direction's light that hills take by their shade on the air: each of `count` places along it, drawn,
 * stands for an equal part of what the air scatters first. */
np_spectrum np_relief_air_shade(const np_relief_air *air, const np_world *world, np_dvec3 origin, np_vec3 towards,
                                int count, np_random *random);

/* In-scatter up to ground at a distance, without what the air scatters first in the shade of hills, and transmittance.
 * False: there are no tables of the air, and `out` is not set. */
bool np_relief_trace_air(const np_world *world, np_dvec3 origin, np_vec3 direction, double distance_m,
                         np_random *random, np_air_parts *out);

np_glow_cosines np_relief_sky_aim(const np_relief_sky *sky, np_vec3 normal);

/* Irradiance of the glow on a slope, of which each direction has `left`. */
np_spectrum np_relief_sky_compute_glow(const np_relief_sky *sky, const np_glow_cosines *cosines,
                                       const np_spectrum left[NP_RELIEF_GLOW]);

#endif
