/* SPDX-License-Identifier: Apache-2.0 */
/* Bright parts of sky and ground, for the tracer to aim at.
 *
 * Light from around that is alike everywhere is met by chance without any noise: every path leaves the clouds once, and
 * sees it (the white furnace). Aiming at it would add noise, of how often a path comes near the clouds' rim. So only
 * what is more than `np_sky_guide_bright` times as bright as the mean of the sphere is aimed at, by how much it is so.
 * That excess, as a share of all light, the sun's with it, is how much of a picture's noise can be its own, and it is
 * the rate at which it is aimed at too: a quarter at dusk, almost nothing where the sun shines on the clouds, and none
 * under a uniform sky. The dearer a ray, the fewer: through air that is traced one costs several times what it does to
 * the tables. A rate below a twentieth brings less than it costs, and nothing is aimed at.
 */
#ifndef NP_CACHES_SKY_GUIDE_H
#define NP_CACHES_SKY_GUIDE_H

#include "core/random.h"
#include "core/stable.h"
#include "world/world.h"

enum {
  NP_SKY_GUIDE_ROWS = 32, /* rows by elevation: even in the root of its sine, so that the horizon has the finest */
  NP_SKY_GUIDE_COLUMNS = 32,
  NP_SKY_GUIDE_CELLS = NP_SKY_GUIDE_ROWS * NP_SKY_GUIDE_COLUMNS
};

static const float np_sky_guide_bright = 2.0f, np_sky_guide_least_rate = 0.05f;

/* Cost of a ray through traced air, relative to a ray to the tables. */
static const float np_sky_guide_traced_cost = 2.5f;

typedef struct np_sky_guide {
  float rate;                           /* directions sampled at a vertex, below 1; 0: none */
  float excess_sr;                      /* integral of the sampled radiance, in units of the mean radiance */
  float density[NP_SKY_GUIDE_CELLS];    /* density with which a direction is sampled, 1/sr */
  float cumulative[NP_SKY_GUIDE_CELLS]; /* share of this cell and all cells before it */
} np_sky_guide;

/* Surveys sky and ground from a place among the clouds, for rays of some cost. Each band is relative to its mean. */
void np_sky_guide_build(const np_world *world, const np_sun_optical_depth_source *depths, np_dvec3 position,
                        float ray_cost, np_sky_guide *out);

/* Samples a direction; `*out_density` in 1/sr. */
np_vec3 np_sky_guide_draw(const np_sky_guide *guide, np_random *random, float *out_density);

static inline float np_sky_guide_eval(const np_sky_guide *guide, np_vec3 direction) {
  const float height = copysignf(sqrtf(np_minf(fabsf(direction.z), 1.0f)), direction.z);
  const float turns = atan2f(direction.y, direction.x) * (0.5f / NP_PI_F);
  const int row = (int)np_minf(0.5f * NP_SKY_GUIDE_ROWS * (1.0f + height), NP_SKY_GUIDE_ROWS - 1.0f);
  const int column = (int)((turns < 0.0f ? turns + 1.0f : turns) * NP_SKY_GUIDE_COLUMNS) % NP_SKY_GUIDE_COLUMNS;
  return guide->density[row * NP_SKY_GUIDE_COLUMNS + column];
}

/* Radiance for which a direction was sampled, in units of the mean. */
static inline float np_sky_guide_brightness(const np_sky_guide *guide, float density) {
  return np_sky_guide_bright + guide->excess_sr * density;
}

#endif
