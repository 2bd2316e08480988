/* SPDX-License-Identifier: Apache-2.0 */
/* A NetCDF file of the classic format: described, and loaded as a cloud, from disk and from memory. Files of HDF5 are
 * left out: their structure is HDF5's own to check. */
#include "fuzz_support.h"

#include <string.h>

#include <nephos/volume.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 4 || memcmp(data, "CDF", 3) != 0) return 0;
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("field.nc", data, size);
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  char *text;
  fuzz_expect(neph_volume_describe_file(context, path, NEPH_TEXT_JSON, &text));
  neph_text_destroy(context, text);
  desc.policy = NEPH_IMPORT_REPAIR;
  desc.model.beyond = NEPH_STEP_HOLD;
  desc.model.step = 2.0;
  fuzz_expect(neph_volume_load(context, path, &desc, &volume));
  neph_volume_release(volume);
  fuzz_expect(neph_volume_load_memory(context, data, size, &desc, &volume));
  neph_volume_release(volume);
  return 0;
}
