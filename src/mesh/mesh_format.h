/* SPDX-License-Identifier: Apache-2.0 */
/* Formats of meshes, and the axes that point up in them. */
#ifndef NP_MESH_MESH_FORMAT_H
#define NP_MESH_MESH_FORMAT_H

#include <nephos/terrain.h>

#include "core/context_private.h"
#include "core/math.h"

/* Refuses a file of another format than the supported ones; Assimp reads more, and trusts their contents. */
neph_result np_mesh_format_check(neph_context *context, const char *path);

/* Refuses a file whose format has no up axis, unless `up` names one; `key` is its key, for the message. */
neph_result np_mesh_format_check_up(neph_context *context, const char *path, neph_mesh_up up, const char *key);

/* Map that turns a file's coordinates upright, scales them, and turns them about the vertical, counter-clockwise. */
np_affine np_mesh_format_make_turn(const char *path, neph_mesh_up up, double unit_m, double rotation_rad);

#endif
