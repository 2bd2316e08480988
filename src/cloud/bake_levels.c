/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail: a grid of voxels twice as long, each the mean of eight. Optical depth is kept. */
#include <stdlib.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"

static int32_t compute_coarse(int32_t fine) { return (fine >= 0 ? fine / 16 : -((15 - fine) / 16)) * NP_LEAF_EDGE; }

static int compare_origins(const void *a, const void *b) {
  const int32_t *x = a, *y = b;
  for (int i = 0; i < 3; i++)
    if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
  return 0;
}

/* The origins of the coarse leaves, sorted, each once. */
static size_t list_origins(const np_sparse_grid *fine, int32_t (*out)[3]) {
  for (size_t i = 0; i < fine->leaf_count; i++)
    for (int a = 0; a < 3; a++) out[i][a] = compute_coarse(fine->leaves[i].origin[a]);
  qsort(out, fine->leaf_count, sizeof *out, compare_origins);
  size_t count = 0;
  for (size_t i = 0; i < fine->leaf_count; i++)
    if (count == 0 || compare_origins(out[count - 1], out[i])) memmove(out[count++], out[i], sizeof *out);
  return count;
}

static int compare_to_leaf(const void *origin, const void *leaf) {
  return compare_origins(origin, ((const np_leaf *)leaf)->origin);
}

/* Adds an eighth of each voxel to the one that it lies in: in a fixed order, so that sums are the same everywhere. */
static void add_leaf(const np_leaf *fine, np_leaf *coarse) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    if (!(fine->values[n] > 0.0f)) continue;
    const int at[3] = {n / 64, n / 8 % 8, n % 8};
    int to = 0;
    for (int a = 0; a < 3; a++) to = 8 * to + (fine->origin[a] + at[a] - 2 * coarse->origin[a]) / 2;
    coarse->values[to] += 0.125f * fine->values[n];
    coarse->active[to / 64] |= UINT64_C(1) << (to % 64);
  }
}

static neph_result fill_coarse(const np_sparse_grid *fine, int32_t (*origins)[3], np_sparse_grid *coarse) {
  const size_t count = list_origins(fine, origins);
  neph_result result = np_sparse_grid_reserve(coarse, count, 0);
  for (size_t i = 0; !result && i < count; i++)
    if (!np_sparse_grid_add_leaf(coarse, origins[i])) result = NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; !result && i < fine->leaf_count; i++) {
    int32_t origin[3];
    for (int a = 0; a < 3; a++) origin[a] = compute_coarse(fine->leaves[i].origin[a]);
    add_leaf(&fine->leaves[i], bsearch(origin, coarse->leaves, coarse->leaf_count, sizeof(np_leaf), compare_to_leaf));
  }
  return result;
}

neph_result np_cloud_halve_grid(neph_context *context, const np_sparse_grid *fine, const char *name, unsigned factor,
                                np_sparse_grid *out_coarse) {
  char *level_name = np_alloc_printf(context, "%s_%u", name, factor);
  int32_t(*origins)[3] = np_alloc(context, fine->leaf_count, sizeof *origins);
  neph_result result = level_name && (origins || !fine->leaf_count) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_sparse_grid_init(context, level_name, out_coarse);
  if (!result) {
    out_coarse->index_to_world = fine->index_to_world;
    for (int a = 0; a < 3; a++) {
      out_coarse->index_to_world.m[a][a] *= 2;
      out_coarse->index_to_world.m[a][3] += 0.5 * fine->index_to_world.m[a][a];
    }
    if (fine->leaf_count) result = fill_coarse(fine, origins, out_coarse);
  }
  np_alloc_free(context, origins);
  np_alloc_free(context, level_name);
  return result;
}
