/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in a shape of the artist's: the first level of their balls, or a distance on a grid, comes from spheres,
 * curves, a closed mesh or a height map. */
#ifndef NP_CLOUD_SHAPE_H
#define NP_CLOUD_SHAPE_H

#include "cloud/cloud_private.h"
#include "core/hash.h"
#include "core/json.h"
#include "mesh/mesh_tree.h"

/* ---- Descriptions: shape_desc.c ---- */

static inline bool np_cloud_desc_has_shape(const neph_cloud_desc *desc) {
  const neph_cloud_shape *shape = &desc->shape;
  return shape->spheres.count || shape->curves.count || shape->mesh_file || shape->height_map;
}

neph_result np_shape_check(neph_context *context, const neph_cloud_desc *desc);

/* Files count by their contents; nothing without a shape. */
neph_result np_shape_put_json(neph_context *context, np_json *json, const neph_cloud_desc *desc);
neph_result np_shape_read_json(neph_context *context, const np_json_value *json, neph_cloud_desc *desc);

/* Adds all but files' contents, which are added by path, size and time of change, and takes pointers out. */
void np_shape_add_hash(np_hash *hash, neph_cloud_shape *shape);

/* Frees what np_shape_read_json made. */
void np_shape_clear_desc(neph_context *context, neph_cloud_desc *desc);

/* ---- The shape: shape.c ---- */

/* Makes the grid, where there is one, and the map of the shape's shadow, for rain. */
neph_result np_shape_build(np_cloud_model *model, np_monitor *monitor);

/* Adds the first level: balls of spheres and curves, perhaps none. */
neph_result np_shape_add_balls(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m);

/* Warns where billows reach beyond the field. */
void np_shape_check_billows(const np_cloud_model *model);

/* ---- Meshes: shape_mesh.c ---- */

/* Triangles in the field's coordinates, not sorted yet. */
neph_result np_shape_load_mesh(const np_cloud_model *model, np_monitor *monitor, np_mesh_tree *out_tree);

/* Triangles about the body below a height map; its bottom lies below the base. */
neph_result np_shape_load_heights(const np_cloud_model *model, np_mesh_tree *out_tree);

/* Signed distance to triangles; refuses a surface that is not closed. */
neph_result np_shape_measure(const np_cloud_model *model, np_monitor *monitor, const char *file, np_mesh_tree *tree,
                             np_shape_grid *out_grid);

#endif
