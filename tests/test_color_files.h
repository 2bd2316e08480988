/* SPDX-License-Identifier: Apache-2.0 */
/* Files of a cloud with colours, or with light that it emits, voxel by voxel, for tests. Voxels are 1 m wide. */
#ifndef NP_TEST_COLOR_FILES_H
#define NP_TEST_COLOR_FILES_H

#include "test_support.h"

#include "volume/volume_private.h"

enum { TEST_COLOR_EDGE = 32, TEST_COLOR_GRIDS = 3 }; /* edge of the lattice, from 0 on; grids of three components */

typedef void test_color_fn(const int32_t at[3], float out[3]);

/* A grid of three components; `names` are those of three floats, or the first alone is that of a vector. */
typedef struct test_color_grid {
  const char *names[3];
  test_color_fn *get;
} test_color_grid;

typedef struct test_color_file {
  float (*get_density)(const int32_t at[3]);
  test_color_grid colors[TEST_COLOR_GRIDS];
} test_color_file;

typedef struct test_color_source {
  const test_color_file *file;
  int color, component; /* color −1: the density */
} test_color_source;

static inline float test_color_get(const test_color_source *s, const int32_t at[3]) {
  float values[3] = {s->file->get_density(at)};
  if (s->color >= 0) s->file->colors[s->color].get(at, values);
  return values[s->component];
}

/* Active where the density is above 0. */
static inline void test_color_fill(neph_context *context, const char *name, const test_color_source *source,
                                   np_sparse_grid *grid) {
  int32_t o[3];
  assert_int_equal(np_sparse_grid_init(context, name, grid), NEPH_OK);
  grid->index_to_world = np_affine_identity();
  for (o[0] = 0; o[0] < TEST_COLOR_EDGE; o[0] += NP_LEAF_EDGE)
    for (o[1] = 0; o[1] < TEST_COLOR_EDGE; o[1] += NP_LEAF_EDGE)
      for (o[2] = 0; o[2] < TEST_COLOR_EDGE; o[2] += NP_LEAF_EDGE) {
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, o);
        assert_non_null(leaf);
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const int32_t at[3] = {o[0] + (n >> 6), o[1] + (n >> 3 & 7), o[2] + (n & 7)};
          if (!(source->file->get_density(at) > 0.0f)) continue;
          leaf->values[n] = test_color_get(source, at);
          leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
        }
      }
}

static inline void test_color_write(neph_context *context, const char *path, const test_color_file *file) {
  np_sparse_grid grids[1 + 3 * TEST_COLOR_GRIDS];
  np_vdb_write_grid outputs[1 + 3 * TEST_COLOR_GRIDS] = {{.grid = &grids[0]}};
  size_t count = 1, used = 1;
  test_color_fill(context, "density", &(test_color_source){file, -1, 0}, &grids[0]);
  for (int g = 0; g < TEST_COLOR_GRIDS && file->colors[g].get; g++) {
    const test_color_grid *color = &file->colors[g];
    const bool is_vector = !color->names[1];
    for (int c = 0; c < 3; c++)
      test_color_fill(context, color->names[is_vector ? 0 : c], &(test_color_source){file, g, c},
                      &grids[used + (size_t)c]);
    if (is_vector)
      outputs[count++] = (np_vdb_write_grid){.grid = &grids[used], .y = &grids[used + 1], .z = &grids[used + 2]};
    for (size_t c = 0; c < 3 && !is_vector; c++) outputs[count++] = (np_vdb_write_grid){.grid = &grids[used + c]};
    used += 3;
  }
  assert_int_equal(np_volume_save_grids(context, path, outputs, count, NULL), NEPH_OK);
  for (size_t g = 0; g < used; g++) np_sparse_grid_clear(&grids[g]);
}

#endif
