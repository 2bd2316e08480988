/* SPDX-License-Identifier: Apache-2.0 */
/* Ground around the middle of a terrain, as the air above it has light from there. */
#ifndef NP_TERRAIN_TERRAIN_SURROUNDINGS_H
#define NP_TERRAIN_TERRAIN_SURROUNDINGS_H

#include "core/units.h"
#include "terrain/terrain_private.h"

/* A place in plan. */
typedef struct np_terrain_spot {
  double x_m, y_m;
} np_terrain_spot;

/* Height of the air that the ground brightens: of the light that it has from the ground, the share H/√(r² + H²) comes
 * from farther than r. */
static const double np_terrain_air_height_m = 8000.0;

/* The place, around the middle of a terrain's sides, of two numbers in [0, 1): even ones choose places as many at each
 * distance as the air has light from. */
static inline np_terrain_spot np_terrain_choose_spot(const double low[2], const double high[2], double distance,
                                                     double azimuth) {
  const double share = 1.0 - distance, away_m = np_terrain_air_height_m * sqrt(1.0 / (share * share) - 1.0);
  const double angle = 2.0 * NP_PI * azimuth;
  return (np_terrain_spot){0.5 * (low[0] + high[0]) + away_m * cos(angle),
                           0.5 * (low[1] + high[1]) + away_m * sin(angle)};
}

/* Share of the ground that water at a level covers: so weighted, and 1 without a height field. */
double np_terrain_measure_water(const neph_terrain *terrain, double level_m);

/* Share of the air within the terrain's sides that has the sun's glint on such water: hills hide the sun from the
 * water, and the water from the air. */
double np_terrain_measure_glint(const neph_terrain *terrain, double level_m, np_vec3 to_sun);

#endif
