/* SPDX-License-Identifier: Apache-2.0 */
/* Loads the table of nephos_vdb.so on first need. */
#include "volume/volume_private.h"

#include "core/module.h"

/* 65 MB of address space, measured. OpenVDB's log4cplus starts the threads while it is loaded, and ends the process if
 * it cannot. */
static const np_module_kind vdb_kind = {.file = NP_VDB_MODULE_FILE,
                                        .function = NP_VDB_MODULE_FUNCTION,
                                        .version = NP_VDB_MODULE_VERSION,
                                        .purpose = "reads and writes .vdb files",
                                        .library_bytes = 72 << 20,
                                        .library_threads = 4};

bool np_vdb_module_is_present(neph_context *context) { return np_module_is_present(context, &vdb_kind); }

neph_result np_vdb_module_get(neph_context *context, const np_vdb_module **out_module) {
  const void *table;
  neph_result result = np_module_get(context, &vdb_kind, &table);
  *out_module = table;
  return result;
}
