/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles of a mesh, their shared vertices, and normals at vertices. */
#ifndef NP_MESH_MESH_SHAPE_H
#define NP_MESH_MESH_SHAPE_H

#include "core/context_private.h"
#include "core/math.h"

/* A mesh in coordinates of its own. Its arrays have one additional float: Embree reads each vertex as four. */
typedef struct np_mesh {
  uint32_t vertex_count, triangle_count;
  float *positions, *normals; /* x, y, z of each vertex; `normals` NULL: flat triangles */
  uint32_t *triangles;        /* three vertices each */
  uint32_t place_count;
  np_dvec3 middle; /* centre of the positions' coordinates */
} np_mesh;

/* Merges all vertices of the same position and, where there are normals, the same normal. */
neph_result np_mesh_join(neph_context *context, np_mesh *mesh);

/* Sets each vertex's normal to the area-weighted mean of its triangles' normals. */
neph_result np_mesh_smooth(neph_context *context, np_mesh *mesh);

#endif
