/* SPDX-License-Identifier: Apache-2.0 */
/* Lists of points [x, y, z, radius], and lists of such lists (curves). */
#ifndef NP_SCENE_SCENE_POINTS_H
#define NP_SCENE_SCENE_POINTS_H

#include "scene/scene_fail.h"
#include "scene/scene_key.h"
#include "core/text.h"

static inline neph_cloud_points *np_scene_points_get(const np_key *key, const void *base) {
  return (neph_cloud_points *)(uintptr_t)((const char *)base + key->field.offset);
}

/* Reads a key of type POINTS or CURVES into new memory; `path` names it in messages. */
neph_result np_scene_points_read(np_scene_problems *problems, const char *path, const np_key *key, const np_node *node,
                                 neph_cloud_points *out_points);

void np_scene_points_add(np_text *out, const neph_cloud_points *points);

void np_scene_points_clear(neph_context *context, neph_cloud_points *points);

#endif
