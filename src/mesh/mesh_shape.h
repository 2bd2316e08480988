/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles of a mesh, the vertices that several of them share, and normals at them. */
#ifndef NP_MESH_MESH_SHAPE_H
#define NP_MESH_MESH_SHAPE_H

#include "core/context_private.h"
#include "core/math.h"

/* In coordinates of its own. One float more than the vertices need is there: Embree reads each as four. */
typedef struct np_mesh {
  uint32_t vertex_count, triangle_count;
  float *positions, *normals; /* x, y, z of each vertex; `normals` NULL: flat triangles */
  uint32_t *triangles;        /* three vertices each */
  uint32_t place_count;
  np_dvec3 middle; /* about which positions are */
} np_mesh;

/* Makes one of all vertices of the same position and, where there are normals, the same normal. */
neph_result np_mesh_join(neph_context *context, np_mesh *mesh);

/* Gives each vertex the mean of the normals of its triangles, by their areas. */
neph_result np_mesh_smooth(neph_context *context, np_mesh *mesh);

#endif
