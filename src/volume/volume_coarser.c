/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_coarser.h"

#include "core/alloc.h"
#include "volume/volume_tint.h"

/* ---- The samples of bricks ---- */

typedef struct sample_job {
  const np_bricks *bricks;
  np_leaf *leaves;
} sample_job;

static neph_result fill_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const sample_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) {
    np_leaf *leaf = &job->leaves[i];
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const np_dvec3 at = np_dvec3_make((double)leaf->origin[0] + n / 64, (double)leaf->origin[1] + n / 8 % 8,
                                        (double)leaf->origin[2] + n % 8);
      leaf->values[n] = np_bricks_sample(job->bricks, at);
      leaf->active[n / 64] |= (uint64_t)(leaf->values[n] > 0.0f) << n % 64;
    }
  }
  return NEPH_OK;
}

static neph_result add_leaves(const np_bricks *bricks, size_t count, np_sparse_grid *grid) {
  int32_t(*cells)[3] = np_alloc(grid->context, count, sizeof *cells);
  if (!cells) return NEPH_ERROR_OUT_OF_MEMORY;
  np_bricks_list_cells(bricks, cells);
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < count && !result; i++) {
    const int32_t origin[3] = {cells[i][0] * NP_LEAF_EDGE, cells[i][1] * NP_LEAF_EDGE, cells[i][2] * NP_LEAF_EDGE};
    if (!np_sparse_grid_add_leaf(grid, origin)) result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_alloc_free(grid->context, cells);
  np_sparse_grid_sort(grid);
  return result;
}

/* Recovers the sparse grid from the bricks of a volume. */
static neph_result recover_grid(const neph_volume *volume, np_monitor *monitor, np_sparse_grid *out_grid) {
  const size_t count = np_bricks_list_cells(&volume->bricks, NULL);
  neph_result result = np_sparse_grid_init(volume->context, volume->name, out_grid);
  out_grid->index_to_world = volume->index_to_world;
  if (!result) result = np_sparse_grid_reserve(out_grid, count, 0);
  if (!result && count) result = add_leaves(&volume->bricks, count, out_grid);
  sample_job job = {&volume->bricks, out_grid->leaves};
  if (!result) result = np_parallel_for(volume->context, monitor, count, 64, fill_leaves, &job);
  return result;
}

/* ---- Levels ---- */

/* Adds the level with half the resolution of `fine`, and returns its grid in `coarse`. */
static neph_result add_level(neph_volume *volume, const np_sparse_grid *fine, neph_precision precision,
                             np_monitor *monitor, np_sparse_grid *coarse) {
  neph_volume *level;
  neph_result result = np_sparse_grid_halve(fine, volume->name, coarse);
  if (!result) result = np_volume_create_from_grid(volume->context, coarse, precision, monitor, &level);
  if (!result) np_tint_add_level(volume->tint, level);
  return result;
}

neph_result np_volume_add_coarser(neph_volume *volume, unsigned count, neph_precision precision, np_monitor *monitor) {
  np_sparse_grid grids[2] = {{0}};
  neph_result result = recover_grid(volume, monitor, &grids[0]);
  if (!result) result = np_tint_create_levels(volume->context, NP_PARTS_OF_COPIES, &volume->tint);
  for (unsigned k = 1; k < count && !result; k++) {
    np_sparse_grid *coarse = &grids[k % 2];
    np_sparse_grid_clear(coarse);
    result = add_level(volume, &grids[1 - k % 2], precision, monitor, coarse);
  }
  for (int i = 0; i < 2; i++) np_sparse_grid_clear(&grids[i]);
  return result;
}
