/* SPDX-License-Identifier: Apache-2.0 */
/* Small .vdb files for tests: boxes of even value in one grid of voxels of 1 m. */
#ifndef NP_TEST_BOX_FILES_H
#define NP_TEST_BOX_FILES_H

#include "test_support.h"

#include "volume/volume_private.h"

enum { TEST_BOX_EDGE = 64 }; /* edge of the lattice that contains the boxes */

typedef struct test_box {
  int32_t low[3], high[3]; /* voxels, from 0 to TEST_BOX_EDGE; `high` is one past the last */
  float value;
} test_box;

static inline bool test_box_has(const test_box *box, const int32_t at[3]) {
  bool is_in = true;
  for (int a = 0; a < 3; a++) is_in = is_in && at[a] >= box->low[a] && at[a] < box->high[a];
  return is_in;
}

static inline void test_boxes_fill(np_leaf *leaf, const test_box *boxes, size_t count) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const int32_t at[3] = {leaf->origin[0] + (n >> 6), leaf->origin[1] + (n >> 3 & 7), leaf->origin[2] + (n & 7)};
    for (size_t i = 0; i < count; i++) {
      if (!test_box_has(&boxes[i], at)) continue;
      leaf->values[n] = boxes[i].value;
      leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
    }
  }
}

/* A file of one grid; an empty one where there are no boxes. */
static inline void test_boxes_write(neph_context *context, const char *path, const char *name, const test_box *boxes,
                                    size_t count) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(context, name, &grid), NEPH_OK);
  grid.index_to_world = np_affine_identity();
  int32_t o[3];
  for (o[0] = 0; count && o[0] < TEST_BOX_EDGE; o[0] += NP_LEAF_EDGE)
    for (o[1] = 0; o[1] < TEST_BOX_EDGE; o[1] += NP_LEAF_EDGE)
      for (o[2] = 0; o[2] < TEST_BOX_EDGE; o[2] += NP_LEAF_EDGE) {
        np_leaf *leaf = np_sparse_grid_add_leaf(&grid, o);
        assert_non_null(leaf);
        test_boxes_fill(leaf, boxes, count);
      }
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(context, path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

/* A file of one tile of 4096³ voxels of 1 m, some 600 bytes. */
static inline void test_tile_write(neph_context *context, const char *path) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(context, "density", &grid), NEPH_OK);
  grid.index_to_world = np_affine_identity();
  (void)np_sparse_grid_add_tile(&grid, (const int32_t[3]){0, 0, 0}, 4096, 1.0f, true);
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(context, path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

#endif
