/* SPDX-License-Identifier: Apache-2.0 */
/* A NetCDF file of the classic format: described, and loaded as a cloud, from disk and from memory. Files of HDF5 are
 * left out: their structure is HDF5's own to check. */
#include "fuzz_support.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 4 || memcmp(data, "CDF", 3) != 0) return 0;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.policy = NEPH_IMPORT_REPAIR;
  desc.model.beyond = NEPH_STEP_HOLD;
  desc.model.step = 2.0;
  fuzz_read_volume("field.nc", data, size, &desc);
  return 0;
}
