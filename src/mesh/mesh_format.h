/* SPDX-License-Identifier: Apache-2.0 */
/* Formats of meshes, and the axes that point up in them. */
#ifndef NP_MESH_MESH_FORMAT_H
#define NP_MESH_MESH_FORMAT_H

#include <nephos/terrain.h>

#include "core/context_private.h"
#include "core/math.h"

/* Refuses a file of another format than the supported ones; Assimp reads more, and trusts their contents. */
neph_result np_mesh_format_check(neph_context *context, const char *path);

/* Requires `up` for a format without a defined up axis; `key` is the scene's key, for the message. */
neph_result np_mesh_format_check_up(neph_context *context, const char *path, neph_mesh_up up, const char *key);

/* Map from a file's coordinates to metres with z up, turned about the vertical counter-clockwise. */
np_affine np_mesh_format_make_turn(const char *path, neph_mesh_up up, double unit_m, double rotation_rad);

#endif
