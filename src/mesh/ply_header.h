/* SPDX-License-Identifier: Apache-2.0 */
/* Header of a PLY file, checked before Assimp makes room for all that it states. */
#ifndef NP_MESH_PLY_HEADER_H
#define NP_MESH_PLY_HEADER_H

#include <nephos/context.h>

/* Refuses a file that states more elements than it has bytes; one that is no PLY passes. */
neph_result np_ply_header_check(neph_context *context, const char *path);

#endif
