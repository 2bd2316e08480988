/* SPDX-License-Identifier: Apache-2.0 */
/* Replaces vdb_module.c in programs with OpenVDB linked in. */
#include "volume/volume_private.h"

neph_result np_vdb_module_get(neph_context *context, const np_vdb_module **out_module) {
  (void)context;
  *out_module = nephos_vdb_module();
  return NEPH_OK;
}

bool np_vdb_module_is_present(neph_context *context) {
  (void)context;
  return true;
}
