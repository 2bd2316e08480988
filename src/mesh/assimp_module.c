/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/assimp_module.h"

#include "core/file.h"
#include "core/module.h"
#include "mesh/mesh_header.h"

/* 22 MB of address space were measured. */
static const np_module_kind assimp_kind = {.file = NP_ASSIMP_MODULE_FILE,
                                           .function = NP_ASSIMP_MODULE_FUNCTION,
                                           .version = NP_ASSIMP_MODULE_VERSION,
                                           .purpose = "reads meshes and cameras by Assimp",
                                           .library_bytes = 32 << 20};

bool np_assimp_module_is_present(neph_context *context) { return np_module_is_present(context, &assimp_kind); }

neph_result np_assimp_module_open(neph_context *context, const char *path, const np_assimp_module **out_module,
                                  np_assimp_scene **out_scene) {
  const char *reason;
  const void *table;
  char message[256] = "";
  *out_scene = NULL;
  neph_result result = np_file_probe(path, &reason);
  if (result) return np_fail(context, result, "%s: %s", path, reason);
  result = np_mesh_header_check(context, path);
  if (!result) result = np_module_get(context, &assimp_kind, &table);
  if (result) return result;
  *out_module = table;
  *out_scene = (*out_module)->open(path, message, sizeof message);
  return *out_scene ? NEPH_OK : np_fail(context, NEPH_ERROR_BAD_FILE, "%s: cannot be read: Assimp: %s", path, message);
}
