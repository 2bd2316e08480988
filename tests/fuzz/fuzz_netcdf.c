/* SPDX-License-Identifier: Apache-2.0 */
/* A NetCDF file of the classic format, or one of HDF5, which a process of its own reads: described, and loaded as a
 * cloud, from disk and from memory. */
#include "fuzz_support.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 8 || (memcmp(data, "CDF", 3) != 0 && memcmp(data, "\211HDF", 4) != 0)) return 0;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.policy = NEPH_IMPORT_REPAIR;
  desc.model.beyond = NEPH_STEP_HOLD;
  desc.model.step = 2.0;
  fuzz_read_volume("field.nc", data, size, &desc);
  return 0;
}
