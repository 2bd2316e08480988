/* SPDX-License-Identifier: Apache-2.0 */
/* A height field as SRTM tiles are: described, and loaded as terrain. */
#include "fuzz_support.h"

#include <nephos/terrain.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("N44W072.hgt", data, size);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *text;
  neph_terrain *terrain;
  fuzz_expect(neph_terrain_describe_file(context, path, NEPH_TEXT_JSON, &text));
  neph_text_destroy(context, text);
  fuzz_expect(neph_terrain_load(context, path, &desc, &terrain));
  neph_terrain_release(terrain);
  return 0;
}
