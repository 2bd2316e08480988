/* SPDX-License-Identifier: Apache-2.0 */
/* Ground around the middle of a terrain, as the air above it has light from there. */
#ifndef NP_TERRAIN_TERRAIN_SURROUNDINGS_H
#define NP_TERRAIN_TERRAIN_SURROUNDINGS_H

#include "terrain/terrain_private.h"

/* A place in plan. */
typedef struct np_terrain_spot {
  double x_m, y_m;
} np_terrain_spot;

/* The place of two numbers in [0, 1): even ones choose places as many at each distance as the air has light from. */
np_terrain_spot np_terrain_choose_spot(const neph_terrain *terrain, double distance, double azimuth);

/* Share of the ground that water at a level covers: so weighted, and 1 without a height field. */
double np_terrain_measure_water(const neph_terrain *terrain, double level_m);

/* Share of the air within the terrain's sides that has the sun's glint on such water: hills hide the sun from the
 * water, and the water from the air. */
double np_terrain_measure_glint(const neph_terrain *terrain, double level_m, np_vec3 to_sun);

#endif
