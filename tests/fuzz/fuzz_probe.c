/* SPDX-License-Identifier: Apache-2.0 */
/* The cases of a probe, few paths each: those of slabs, or, where the first byte is odd, of skies. */
#include "fuzz_support.h"

#include <nephos/probe.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_probe_desc slab = NEPH_PROBE_DESC_DEFAULT;
  neph_probe_sky_desc sky = NEPH_PROBE_SKY_DESC_DEFAULT;
  char *text;
  if (size == 0 || size > 600) return 0; /* a few rows: each takes milliseconds */
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("cases.csv", data + 1, size - 1);
  slab.path_count = sky.path_count = 1;
  slab.path_guiding = NEPH_PATH_GUIDING_NONE;
  fuzz_expect(data[0] & 1 ? neph_probe_sky(context, path, &sky, &text) : neph_probe_slab(context, path, &slab, &text));
  neph_text_destroy(context, text);
  return 0;
}
