/* SPDX-License-Identifier: Apache-2.0 */
/* Messages of bad scenes. */
#ifndef NP_SCENE_SCENE_FAIL_H
#define NP_SCENE_SCENE_FAIL_H

#include "scene/scene_node.h"
#include "scene/scene_private.h"

/* Logs a bad scene at a line and column; 0: without a place. */
neph_result np_scene_fail_text(const neph_scene *scene, unsigned line, unsigned column, const char *text);

/* Logs a bad scene: "file:line:column: what"; without a place when `node` has none or is NULL. */
neph_result np_scene_fail_at(const neph_scene *scene, const np_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
