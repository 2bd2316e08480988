/* SPDX-License-Identifier: Apache-2.0 */
/* A .nvdb file: described, which reads every grid of it, and loaded as a cloud, from disk and from memory.
 *
 * An input that begins with "edit" is changes to a sound file of one leaf, which would be too large for a corpus: each
 * a part of it, a place within that part, and 8 bytes that are put there. Any other is a file as it stands. */
#include "fuzz_support.h"

#include <stdlib.h>
#include <string.h>

#include <nephos/volume.h>

/* Positions in the sound file, of NanoVDB 32.4: a grid of floats behind head, description and name. */
enum {
  META = 16,
  GRID = META + 176 + 8,
  TREE = GRID + 672,
  ROOT = TREE + 64,
  TILE = ROOT + 64,
  UPPER = TILE + 32,
  UPPER_CHILDREN = UPPER + 4128,
  UPPER_TABLE = UPPER + 8256,
  LOWER = UPPER + 270400,
  LOWER_CHILDREN = LOWER + 544,
  LOWER_TABLE = LOWER + 1088,
  LEAF = LOWER + 33856,
  END = LEAF + 2144
};

static void put(uint8_t *file, size_t at, uint64_t value, size_t bytes) { memcpy(file + at, &value, bytes); }

static void put_real(uint8_t *file, size_t at, double value) { memcpy(file + at, &value, sizeof value); }

static void make_heads(uint8_t *file) {
  static const char magic[] = "NanoVDB0";
  const uint64_t version = 32u << 21 | 4u << 10 | 2u, is_fog = 2, is_float = 1;
  memcpy(file, magic, 8);
  put(file, 8, version, 4);
  put(file, 12, 1, 2); /* one grid, not compressed */
  put(file, META, END - GRID, 8);
  put(file, META + 8, END - GRID, 8);
  put(file, META + 32, is_float, 4);
  put(file, META + 36, is_fog, 4);
  put(file, META + 136, 8, 4);
  memcpy(file + META + 176, "density", 8);
  memcpy(file + GRID, magic, 8);
  put(file, GRID + 8, UINT64_MAX, 8); /* no checksum */
  put(file, GRID + 16, version, 4);
  put(file, GRID + 32, END - GRID, 8);
  for (size_t a = 0; a < 3; a++) put_real(file, GRID + 296 + 88 + 32 * a, 1.0);
  put(file, GRID + 632, is_fog, 4);
  put(file, GRID + 636, is_float, 4);
}

static void make_tree(uint8_t *file) {
  const float one = 1.0f;
  put(file, TREE, LEAF - TREE, 8);
  put(file, TREE + 8, LOWER - TREE, 8);
  put(file, TREE + 16, UPPER - TREE, 8);
  put(file, TREE + 24, ROOT - TREE, 8);
  for (size_t level = 0; level < 3; level++) put(file, TREE + 32 + 4 * level, 1, 4);
  put(file, ROOT + 24, 1, 4);
  put(file, TILE + 8, UPPER - ROOT, 8);
  put(file, UPPER_CHILDREN, 1, 8);
  put(file, UPPER_TABLE, LOWER - UPPER, 8);
  put(file, LOWER_CHILDREN, 1, 8);
  put(file, LOWER_TABLE, LEAF - LOWER, 8);
  memset(file + LEAF + 16, 0xff, 64);
  for (size_t n = 0; n < 512; n++) memcpy(file + LEAF + 96 + 4 * n, &one, sizeof one);
}

static void change(uint8_t *file, const uint8_t *data, size_t size) {
  static const size_t parts[] = {0,           META,  GRID,           TREE,        ROOT, TILE, UPPER, UPPER_CHILDREN,
                                 UPPER_TABLE, LOWER, LOWER_CHILDREN, LOWER_TABLE, LEAF};
  enum { EDIT_BYTES = 1 + 2 + 8 };
  for (; size >= EDIT_BYTES; data += EDIT_BYTES, size -= EDIT_BYTES) {
    const size_t at = parts[data[0] % (sizeof parts / sizeof *parts)] + (size_t)(data[1] | data[2] << 8);
    if (at + 8 <= END) memcpy(file + at, data + 3, 8);
  }
}

static void read_file(const uint8_t *data, size_t size) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.policy = NEPH_IMPORT_REPAIR;
  fuzz_read_volume("cloud.nvdb", data, size, &desc);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 4 || memcmp(data, "edit", 4) != 0) {
    read_file(data, size);
    return 0;
  }
  uint8_t *file = calloc(1, END);
  if (!file) return 0;
  make_heads(file);
  make_tree(file);
  change(file, data + 4, size - 4);
  read_file(file, END);
  free(file);
  return 0;
}
