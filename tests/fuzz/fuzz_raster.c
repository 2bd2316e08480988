/* SPDX-License-Identifier: Apache-2.0 */
/* A height field that GDAL reads, of the format that the first byte chooses: described, and loaded as terrain. */
#include "fuzz_support.h"

#include <nephos/terrain.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char *const names[] = {"tile.tif", "tile.asc", "tile.dem", "tile.img", "tile.dt0", "tile.hgt.zip"};
  if (size == 0) return 0;
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file(names[data[0] % (sizeof names / sizeof *names)], data + 1, size - 1);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *text;
  neph_terrain *terrain;
  desc.edge = NEPH_TERRAIN_EDGE_WALL; /* a margin of 80 samples would be most of the work */
  fuzz_expect(neph_terrain_describe_file(context, path, NEPH_TEXT_JSON, &text));
  neph_text_destroy(context, text);
  fuzz_expect(neph_terrain_load(context, path, &desc, &terrain));
  neph_terrain_release(terrain);
  return 0;
}
