/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles of a mesh file, each mesh once, and the places where its nodes put them. */
#ifndef NP_MESH_MESH_FILE_H
#define NP_MESH_MESH_FILE_H

#include "core/parallel.h"
#include "mesh/mesh_shape.h"

typedef struct np_mesh_place {
  uint32_t mesh;
  np_affine to_file;
} np_mesh_place;

typedef struct np_mesh_file {
  neph_context *context; /* borrowed */
  size_t mesh_count, place_count;
  np_mesh *meshes; /* meshes of triangles alone; some may be empty */
  np_mesh_place *places;
} np_mesh_file;

/* Loads all triangles; fails where there are none, or where a vertex is not finite. `monitor` may be NULL. */
neph_result np_mesh_file_load(neph_context *context, const char *path, bool is_smooth, np_monitor *monitor,
                              np_mesh_file *out_file);
void np_mesh_file_clear(np_mesh_file *file);

#endif
