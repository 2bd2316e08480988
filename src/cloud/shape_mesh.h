/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes from closed surfaces. */
#ifndef NP_CLOUD_SHAPE_MESH_H
#define NP_CLOUD_SHAPE_MESH_H

#include "cloud/cloud_model.h"
#include "mesh/mesh_tree.h"

/* Loads triangles in field coordinates, not sorted yet. */
neph_result np_shape_load_mesh(const np_cloud_model *model, np_monitor *monitor, np_mesh_tree *out_tree);

/* Triangles of the body below a height map; its bottom is below the base. */
neph_result np_shape_load_heights(const np_cloud_model *model, np_mesh_tree *out_tree);

/* Signed distance to triangles; refuses a surface that is not closed. */
neph_result np_shape_measure(const np_cloud_model *model, np_monitor *monitor, const char *file, np_mesh_tree *tree,
                             np_shape_grid *out_grid);

#endif
