/* SPDX-License-Identifier: Apache-2.0 */
/* Random sparse grids for the tests of the volume module, each from a seed. */
#ifndef NP_TEST_GRIDS_H
#define NP_TEST_GRIDS_H

#include "test_support.h"

#include "core/random.h"
#include "volume/volume_private.h"

static inline void test_fill_leaf(np_leaf *leaf, np_random *random) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    leaf->values[n] = np_random_float(random);
    leaf->active[n >> 6] |= (np_random_bits(random) >> 63) << (n & 63);
  }
}

/* Blocks of 8³ from −`radius` to `radius` along each axis: leaves of random values, active and inactive tiles that
 * differ from their neighbours and from the background, tiles that equal them, and nothing. One tile of 128³ stands
 * beside. */
static inline void test_make_grid(neph_context *context, uint64_t seed, int32_t radius, np_sparse_grid *out_grid) {
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  assert_int_equal(np_sparse_grid_init(context, "density", out_grid), NEPH_OK);
  int32_t block[3];
  for (block[0] = -radius; block[0] < radius; block[0]++)
    for (block[1] = -radius; block[1] < radius; block[1]++)
      for (block[2] = -radius; block[2] < radius; block[2]++) {
        const int32_t origin[3] = {8 * block[0], 8 * block[1], 8 * block[2]};
        float choice = np_random_float(&random), value = np_random_float(&random);
        if (choice < 0.3f)
          test_fill_leaf(np_sparse_grid_add_leaf(out_grid, origin), &random);
        else if (choice < 0.5f)
          (void)np_sparse_grid_add_tile(out_grid, origin, 8, value < 0.5f ? 0.25f : value, choice < 0.4f);
      }
  (void)np_sparse_grid_add_tile(out_grid, (const int32_t[3]){128, 0, -128}, 128, 0.75f, true);
  np_sparse_grid_sort(out_grid);
}

static inline double test_random_in(np_random *random, double low, double high) {
  return low + (high - low) * np_random_double(random);
}

#endif
