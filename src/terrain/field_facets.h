/* SPDX-License-Identifier: Apache-2.0 */
/* The triangles of a height field, two a cell: exact intersections of rays with them, and smooth normals. */
#ifndef NP_TERRAIN_FIELD_FACETS_H
#define NP_TERRAIN_FIELD_FACETS_H

#include "terrain/terrain_private.h"

/* A field's triangles. Rays and vertices are relative to the same anchor. */
typedef struct np_field_facets {
  const np_heightfield *field;
  const float *vertices; /* x, y, z of each sample */
} np_field_facets;

/* Smooth normal, bilinear in the normals of a cell's four samples. */
np_vec3 np_field_facets_get_normal(const np_field_facets *facets, np_field_position position);

/* Intersection of a ray with the triangle at a position, or, where that is slightly wrong, with its neighbour. */
bool np_field_facets_intersect(const np_field_facets *facets, np_dvec3 origin, np_vec3 direction, double distance_max,
                               np_field_position guess, np_terrain_hit *out_hit);

#endif
