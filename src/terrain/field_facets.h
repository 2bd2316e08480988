/* SPDX-License-Identifier: Apache-2.0 */
/* The triangles of a height field, two a cell: exact meetings of rays with them, and smooth normals. */
#ifndef NP_TERRAIN_FIELD_FACETS_H
#define NP_TERRAIN_FIELD_FACETS_H

#include "terrain/terrain_private.h"

/* Rays are about the point that the vertices are about. */
typedef struct np_field_facets {
  const np_heightfield *field;
  const float *vertices; /* x, y, z of each sample */
} np_field_facets;

/* Bilinear in the normals of a cell's four samples. */
np_vec3 np_field_facets_get_normal(const np_field_facets *facets, np_field_position position);

/* The meeting of a ray with the triangle at a place, or, where that errs, with its neighbour. */
bool np_field_facets_intersect(const np_field_facets *facets, np_dvec3 origin, np_vec3 direction, double distance_max,
                               np_field_position guess, np_terrain_hit *out_hit);

#endif
