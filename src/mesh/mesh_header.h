/* SPDX-License-Identifier: Apache-2.0 */
/* Headers of PLY and GLB files, checked before Assimp allocates all that they state, and faces of OBJ files. */
#ifndef NP_MESH_MESH_HEADER_H
#define NP_MESH_MESH_HEADER_H

#include <nephos/context.h>

/* Refuses a file whose header states more than the file can hold, or an OBJ without a face; files of other formats
 * pass. */
neph_result np_mesh_header_check(neph_context *context, const char *path);

#endif
