/* SPDX-License-Identifier: Apache-2.0 */
/* The table of nephos_assimp.so. */
#ifndef NP_MESH_ASSIMP_MODULE_H
#define NP_MESH_ASSIMP_MODULE_H

#include "core/context_private.h"
#include "mesh/assimp_table.h"

/* Whether there is the module; logs nothing. */
bool np_assimp_module_is_present(neph_context *context);

/* Reads a file through the module, which is loaded on first need. The scene is closed by the module's `close`. */
neph_result np_assimp_module_open(neph_context *context, const char *path, const np_assimp_module **out_module,
                                  np_assimp_scene **out_scene);

#endif
