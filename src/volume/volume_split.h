/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a density that add up to it: each voxel is split among them by its shares. Inside the volume module only. */
#ifndef NP_VOLUME_VOLUME_SPLIT_H
#define NP_VOLUME_VOLUME_SPLIT_H

#include "volume/volume_tint.h"

enum { NP_SPLIT_BLOCKS_MAX = 1 << 20 };

typedef struct np_split {
  neph_context *context;
  const neph_volume *density;
  neph_precision precision; /* precision of the parts */
  np_monitor *monitor;
  bool is_level; /* the density is one of several levels of detail, which is used for its own cells alone */
  size_t block_count, border_count;
  /* Owned; in brick coordinates, blocks of 8³ voxels that are not empty, then, of a level, the blocks of other levels
   * whose first samples its blocks share. */
  int32_t (*cells)[3];
  /* Shares of the parts in voxel n of a block (x slowest, z fastest), where the density is above 0. */
  void (*compute_shares)(const void *user, size_t block, int n, float out[NP_TINT_PARTS_MAX]);
  const void *user;
} np_split;

/* Lists the blocks. Fails if they are too many, and names `key`, whose word none leaves the parts out. */
neph_result np_split_start(np_split *split, const char *path, const char *key);
void np_split_clear(np_split *split);

/* Index position of a voxel in the density. */
static inline np_dvec3 np_split_get_index(const np_split *split, size_t block, int n) {
  const int32_t *cell = split->cells[block];
  return np_dvec3_make((double)cell[0] * NP_BRICK_EDGE + (n >> 6), (double)cell[1] * NP_BRICK_EDGE + (n >> 3 & 7),
                       (double)cell[2] * NP_BRICK_EDGE + (n & 7));
}

static inline float np_split_get_density(const np_split *split, size_t block, int n) {
  return np_bricks_sample(&split->density->bricks, np_split_get_index(split, block, n));
}

/* Creates the volume of a part, with the lattice and the periods of the density; NULL if no voxel has a share of it. */
neph_result np_split_make_part(const np_split *split, unsigned part, neph_volume **out_volume);

#endif
