/* SPDX-License-Identifier: Apache-2.0 */
/* A picture of a whole sphere, by longitude and latitude: of the starry sky, of the moon. */
#ifndef NP_ATMOSPHERE_SPHERE_MAP_H
#define NP_ATMOSPHERE_SPHERE_MAP_H

#include "core/context_private.h"
#include "core/spectrum.h"

typedef struct np_sphere_map {
  neph_context *context;
  unsigned width, height;
  np_spectrum *texels; /* row by row from the north pole */
  float east;          /* +1: longitudes grow to the right, as on globes; −1: to the left, as in the sky from inside */
} np_sphere_map;

/* Reads an OpenEXR of R, G, B, or of Y alone, longitude 0 in the middle, twice as wide as high. NaN, infinite and
 * negative values are refused, by pixel; `what` names the key in messages. On failure nothing is left. */
neph_result np_sphere_map_load(neph_context *context, const char *what, const char *path, bool is_inside,
                               np_sphere_map *out_map);

/* Whether a file is one, by its header alone. */
neph_result np_sphere_map_check(neph_context *context, const char *what, const char *path);
void np_sphere_map_clear(np_sphere_map *map);

/* Bilinear; the direction of any length, x towards longitude 0, y towards 90° east, z to the north pole. */
np_spectrum np_sphere_map_lookup(const np_sphere_map *map, float x, float y, float z);

#endif
