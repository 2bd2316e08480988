/* SPDX-License-Identifier: Apache-2.0 */
/* Method: NanoVDB 32.4, util/GridChecksum.h: a CRC-32 of head, tree and root behind the checksum itself, and one of the
 * sums of all nodes, each 8 bytes, upper nodes first. Eight bytes at a time: M. E. Kounavis and F. L. Berry, "A
 * systematic approach to building high performance software-based CRC generators" (ISCC 2005). */
#include "volume/nvdb_checksum.h"

#include <string.h>

#include "volume/nvdb_header.h"

enum {
  SLICES = 8,
  PIECE_BYTES = 4096,
  CHECKED_FROM = 16,
  ROOT_TILE_COUNT = 24,
  MINOR_KNOWN = 4,
  IS_BREADTH_FIRST = 32
};

static const uint32_t polynomial = 0xedb88320u, none = 0xffffffffu;

typedef struct crc {
  uint32_t tables[SLICES][256];
  uint32_t state;
} crc;

static void start(crc *c) {
  for (uint32_t n = 0; n < 256; n++) {
    uint32_t value = n;
    for (int bit = 0; bit < 8; bit++) value = value >> 1 ^ (value & 1u ? polynomial : 0u);
    c->tables[0][n] = value;
  }
  for (int s = 1; s < SLICES; s++)
    for (int n = 0; n < 256; n++)
      c->tables[s][n] = c->tables[s - 1][n] >> 8 ^ c->tables[0][c->tables[s - 1][n] & 0xffu];
  c->state = none;
}

static void add(crc *c, const unsigned char *bytes, size_t count) {
  uint32_t state = c->state;
  for (; count >= SLICES; bytes += SLICES, count -= SLICES) {
    uint32_t words[2];
    memcpy(words, bytes, sizeof words);
    words[0] ^= state;
    state = 0;
    for (int s = 0; s < 4; s++) {
      state ^= c->tables[7 - s][words[0] >> (8 * s) & 0xffu];
      state ^= c->tables[3 - s][words[1] >> (8 * s) & 0xffu];
    }
  }
  for (; count > 0; bytes++, count--) state = state >> 8 ^ c->tables[0][(state ^ *bytes) & 0xffu];
  c->state = state;
}

/* The sum of a part of the grid, from its start on. */
static uint32_t compute(np_vdb_bytes *bytes, int64_t at, uint64_t count, crc *c) {
  unsigned char piece[PIECE_BYTES];
  c->state = none;
  np_vdb_bytes_seek(bytes, at);
  while (count > 0 && !bytes->result) {
    const uint64_t part = count < sizeof piece ? count : sizeof piece;
    np_vdb_bytes_read(bytes, piece, part);
    add(c, piece, part);
    count -= part;
  }
  return ~c->state;
}

static void compare(np_vdb_bytes *bytes, uint32_t stated, uint32_t computed, const char *part) {
  if (stated != computed)
    np_vdb_bytes_fail(bytes, "the checksum of its %s is %08lx, and it states %08lx", part, (unsigned long)computed,
                      (unsigned long)stated);
}

static void check_head(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, uint32_t stated, crc *c) {
  uint32_t tile_count = 0;
  np_vdb_bytes_seek(bytes, begin + (int64_t)grid->root + ROOT_TILE_COUNT);
  np_vdb_bytes_read(bytes, &tile_count, sizeof tile_count);
  const uint64_t end = grid->root + grid->layout.root + (uint64_t)tile_count * grid->layout.root_tile;
  if (end > grid->bytes)
    np_vdb_bytes_fail(bytes, "the root has %lu tiles, more than fit into it", (unsigned long)tile_count);
  if (!bytes->result) compare(bytes, stated, compute(bytes, begin + CHECKED_FROM, end - CHECKED_FROM, c), "head");
}

static void check_nodes(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, uint32_t stated, crc *c) {
  const uint32_t sizes[NP_NVDB_LEVELS] = {grid->layout.leaf, grid->layout.lower, grid->layout.upper};
  uint64_t offsets[NP_NVDB_LEVELS] = {0};
  crc all = *c;
  np_vdb_bytes_seek(bytes, begin + NP_NVDB_GRID_BYTES);
  np_vdb_bytes_read(bytes, offsets, sizeof offsets);
  all.state = none;
  for (int level = NP_NVDB_LEVELS - 1; level >= 0; level--) {
    const uint64_t at = NP_NVDB_GRID_BYTES + offsets[level], count = grid->node_counts[level];
    if (at > grid->bytes || count * sizes[level] > grid->bytes - at)
      np_vdb_bytes_fail(bytes, "its nodes of level %d stand at byte %llu of %llu", level, (unsigned long long)at,
                        (unsigned long long)grid->bytes);
    for (uint64_t i = 0; i < count && !bytes->result; i++) {
      const uint64_t sum = compute(bytes, begin + (int64_t)(at + i * sizes[level]), sizes[level], c);
      add(&all, (const unsigned char *)&sum, sizeof sum);
    }
  }
  if (!bytes->result) compare(bytes, stated, ~all.state, "nodes");
}

neph_result np_nvdb_checksum_check(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid) {
  uint32_t stated[2], version, flags;
  crc c;
  bytes->grid = grid->name;
  np_vdb_bytes_seek(bytes, begin + PNANOVDB_GRID_OFF_CHECKSUM);
  np_vdb_bytes_read(bytes, stated, sizeof stated);
  np_vdb_bytes_read(bytes, &version, sizeof version);
  np_vdb_bytes_read(bytes, &flags, sizeof flags);
  const bool is_known =
      (version >> 10 & 0x7ffu) <= MINOR_KNOWN && grid->root == NP_NVDB_GRID_BYTES + NP_NVDB_TREE_BYTES;
  const bool is_ordered = flags & IS_BREADTH_FIRST && !grid->type->get_tail && grid->node_counts[2];
  start(&c);
  if (is_known && stated[0] != none) check_head(bytes, begin, grid, stated[0], &c);
  if (is_known && is_ordered && stated[0] != none && stated[1] != none && !bytes->result)
    check_nodes(bytes, begin, grid, stated[1], &c);
  bytes->grid = NULL;
  return bytes->result;
}
