/* SPDX-License-Identifier: Apache-2.0 */
/* Vertices that several triangles share, and normals at them. */
#ifndef NP_MESH_MESH_SHAPE_H
#define NP_MESH_MESH_SHAPE_H

#include "mesh/mesh_file.h"

/* Makes one of all vertices of the same position and, where there are normals, the same normal. */
neph_result np_mesh_join(neph_context *context, np_mesh *mesh);

/* Gives each vertex the mean of the normals of its triangles, by their areas. */
neph_result np_mesh_smooth(neph_context *context, np_mesh *mesh);

#endif
