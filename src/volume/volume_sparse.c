/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes from lists of samples. Adjacent samples in the caller's arrays mostly lie in one leaf: such a run is one
 * entry, and entries are sorted by leaf. */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "volume/volume_private.h"

/* Far beyond the limit of bricks (bricks_table.c), and far from the end of 32 bits. */
static const int32_t coordinate_max = 1 << 30;

typedef struct run {
  int32_t origin[3]; /* origin of the leaf that holds the samples */
  size_t first, count;
} run;

typedef struct run_list {
  run *runs;
  size_t count, capacity;
} run_list;

/* ---- Checks ---- */

static neph_result refuse_sample(neph_context *context, const neph_volume_sparse_desc *desc, size_t n,
                                 const char *fault) {
  const int32_t *at = desc->coordinates + 3 * n;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_sparse_desc: sample %zu, %g at (%d, %d, %d), %s", n,
                 (double)desc->values[n], (int)at[0], (int)at[1], (int)at[2], fault);
}

static neph_result check_samples(neph_context *context, const neph_volume_sparse_desc *desc) {
  for (size_t n = 0; n < desc->sample_count; n++) {
    if (!isfinite(desc->values[n]) || desc->values[n] < 0.0f)
      return refuse_sample(context, desc, n, "must be finite and not negative");
    for (int a = 0; a < 3; a++) {
      const int32_t at = desc->coordinates[3 * n + (size_t)a];
      if (at < -coordinate_max || at > coordinate_max)
        return refuse_sample(context, desc, n, "must lie within 1073741824 voxels of index 0 along each axis");
    }
  }
  return NEPH_OK;
}

static neph_result check_sparse(neph_context *context, const neph_volume_sparse_desc *desc) {
  const char *missing = !desc->name ? "name" : !desc->coordinates ? "coordinates" : !desc->values ? "values" : NULL;
  if (missing) return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_sparse_desc.%s is NULL", missing);
  if (desc->sample_count < 1)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_sparse_desc.sample_count is 0, must be at least 1");
  if (desc->precision != NEPH_PRECISION_HALF && desc->precision != NEPH_PRECISION_FLOAT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_sparse_desc.precision is %d, not a neph_precision", (int)desc->precision);
  return check_samples(context, desc);
}

/* ---- Runs ---- */

static run *add_run(neph_context *context, run_list *list) {
  if (list->count == list->capacity) {
    const size_t capacity = list->capacity + list->capacity / 2 + 64;
    run *grown = list->runs ? np_alloc_resize(context, list->runs, capacity, sizeof *grown)
                            : np_alloc(context, capacity, sizeof *grown);
    if (!grown) return NULL;
    list->runs = grown;
    list->capacity = capacity;
  }
  return &list->runs[list->count++];
}

static neph_result list_runs(neph_context *context, const neph_volume_sparse_desc *desc, run_list *list) {
  for (size_t n = 0; n < desc->sample_count; n++) {
    const int32_t *at = desc->coordinates + 3 * n;
    const int32_t origin[3] = {at[0] & -NP_LEAF_EDGE, at[1] & -NP_LEAF_EDGE, at[2] & -NP_LEAF_EDGE};
    run *last = list->count ? &list->runs[list->count - 1] : NULL;
    if (last && !memcmp(last->origin, origin, sizeof origin)) {
      last->count++;
      continue;
    }
    last = add_run(context, list);
    if (!last) return NEPH_ERROR_OUT_OF_MEMORY;
    memcpy(last->origin, origin, sizeof origin);
    last->first = n;
    last->count = 1;
  }
  return NEPH_OK;
}

/* Sorts by leaf, then by array index, so that the message about a repeated sample is deterministic. */
static int compare_runs(const void *a, const void *b) {
  const run *left = a, *right = b;
  for (int i = 0; i < 3; i++)
    if (left->origin[i] != right->origin[i]) return left->origin[i] < right->origin[i] ? -1 : 1;
  return left->first < right->first ? -1 : left->first > right->first;
}

/* ---- Leaves ---- */

static neph_result fill_run(neph_context *context, const neph_volume_sparse_desc *desc, const run *r, np_leaf *leaf) {
  for (size_t n = r->first; n < r->first + r->count; n++) {
    const int32_t *at = desc->coordinates + 3 * n;
    const int i = at[0] - r->origin[0], bit = (at[1] - r->origin[1]) * NP_LEAF_EDGE + at[2] - r->origin[2];
    const uint64_t mask = UINT64_C(1) << bit;
    if (leaf->active[i] & mask) return refuse_sample(context, desc, n, "is there twice: each place has one sample");
    leaf->active[i] |= mask;
    leaf->values[i * NP_LEAF_EDGE * NP_LEAF_EDGE + bit] = desc->values[n];
  }
  return NEPH_OK;
}

static neph_result fill_grid(const neph_volume_sparse_desc *desc, const run_list *list, np_sparse_grid *grid) {
  np_leaf *leaf = NULL;
  neph_result result = NEPH_OK;
  for (size_t n = 0; n < list->count && !result; n++) {
    const run *r = &list->runs[n];
    if (!leaf || memcmp(leaf->origin, r->origin, sizeof r->origin)) leaf = np_sparse_grid_add_leaf(grid, r->origin);
    result = leaf ? fill_run(grid->context, desc, r, leaf) : NEPH_ERROR_OUT_OF_MEMORY;
  }
  return result;
}

static neph_result build_grid(neph_context *context, const neph_volume_sparse_desc *desc, np_sparse_grid *grid) {
  run_list list = {0};
  neph_result result = np_sparse_grid_init(context, desc->name, grid);
  memcpy(grid->index_to_world.m, desc->index_to_world, sizeof desc->index_to_world);
  grid->is_consumed = true;
  if (!result) result = list_runs(context, desc, &list);
  if (!result) qsort(list.runs, list.count, sizeof *list.runs, compare_runs);
  if (!result) result = fill_grid(desc, &list, grid);
  np_alloc_free(context, list.runs);
  return result;
}

neph_result neph_volume_create_sparse(neph_context *context, const neph_volume_sparse_desc *desc,
                                      neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume, desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_volume_sparse_desc defaults = NEPH_VOLUME_SPARSE_DESC_DEFAULT;
  neph_volume_sparse_desc d;
  np_sparse_grid grid = {0};
  neph_result result = np_desc_read(context, "neph_volume_sparse_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check_sparse(context, &d);
  if (result) return result;
  unsigned float_mode = np_float_mode_enter();
  result = build_grid(context, &d, &grid);
  if (!result) result = np_volume_create_from_grid(context, &grid, d.precision, NULL, out_volume);
  np_sparse_grid_clear(&grid);
  np_float_mode_leave(float_mode);
  return result;
}
