/* SPDX-License-Identifier: Apache-2.0 */
/* An image of a whole sphere in longitude and latitude: the starry sky, or the moon. */
#ifndef NP_ATMOSPHERE_SPHERE_MAP_H
#define NP_ATMOSPHERE_SPHERE_MAP_H

#include "core/context_private.h"
#include "core/spectrum.h"

typedef struct np_sphere_map {
  neph_context *context;
  unsigned width, height;
  np_spectrum *texels; /* rows from the north pole down */
  float east; /* +1: longitude grows to the right, as on globes; −1: to the left, as in the sky seen from inside */
} np_sphere_map;

/* Loads an OpenEXR image with R, G, B, or with Y alone, longitude 0 in the middle, twice as wide as high. NaN, infinite
 * and negative pixels are refused with their position; `what` names the scene key in messages. On failure nothing is
 * left. */
neph_result np_sphere_map_load(neph_context *context, const char *what, const char *path, bool is_inside,
                               np_sphere_map *out_map);

/* Checks by the header that a file is an equirectangular image. */
neph_result np_sphere_map_check(neph_context *context, const char *what, const char *path);
void np_sphere_map_clear(np_sphere_map *map);

/* Bilinear look-up; the direction has any length, x towards longitude 0, y towards 90° east, z towards the north pole.
 */
np_spectrum np_sphere_map_lookup(const np_sphere_map *map, float x, float y, float z);

#endif
