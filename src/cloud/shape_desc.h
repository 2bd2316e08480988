/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes in descriptions. */
#ifndef NP_CLOUD_SHAPE_DESC_H
#define NP_CLOUD_SHAPE_DESC_H

#include <nephos/cloud.h>

#include "core/hash.h"
#include "core/json.h"

static inline bool np_cloud_desc_has_shape(const neph_cloud_desc *desc) {
  const neph_cloud_shape *shape = &desc->shape;
  return shape->spheres.count || shape->curves.count || shape->mesh_file || shape->height_map;
}

neph_result np_shape_check(neph_context *context, const neph_cloud_desc *desc);

/* Files are identified by their contents; writes nothing without a shape. */
neph_result np_shape_put_json(neph_context *context, np_json *json, const neph_cloud_desc *desc);
neph_result np_shape_read_json(neph_context *context, const np_json_value *json, neph_cloud_desc *desc);

/* Adds the shape to a hash and clears its pointers. Files are identified by path, size and modification time. */
void np_shape_add_hash(np_hash *hash, neph_cloud_shape *shape);

/* Frees the memory from np_shape_read_json. */
void np_shape_clear_desc(neph_context *context, neph_cloud_desc *desc);

#endif
