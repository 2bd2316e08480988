/* SPDX-License-Identifier: Apache-2.0 */
/* A .vdb file: described, which reads every grid of it, and loaded as a cloud. */
#include "fuzz_support.h"

#include <nephos/volume.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("cloud.vdb", data, size);
  for (int format = NEPH_TEXT_PLAIN; format <= NEPH_TEXT_JSON; format++) {
    char *text;
    fuzz_expect(neph_volume_describe_file(context, path, (neph_text_format)format, &text));
    neph_text_destroy(context, text);
  }
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.policy = NEPH_IMPORT_REPAIR;
  fuzz_expect(neph_volume_load(context, path, &desc, &volume));
  neph_volume_release(volume);
  return 0;
}
