/* SPDX-License-Identifier: Apache-2.0 */
/* Values that a cloud cannot have: each kind counted, with the first voxel, and refused or repaired as the caller says.
 *
 * Values are classified by their bits, because threads run with subnormals flushed to zero.
 */
#include <float.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/volume_file.h"

enum { LEAVES_PER_PIECE = 64 };

/* Negative values this small beside the largest are what rounding leaves of 0. */
static const float rounding_of_max = 1e-6f;

typedef enum kind { KIND_NAN, KIND_INFINITE, KIND_NEGATIVE, KIND_ROUNDING, KIND_SUBNORMAL, KIND_COUNT, KIND_GOOD } kind;

static const char *const kind_names[KIND_COUNT] = {"NaN", "infinite", "negative", "negative by rounding", "subnormal"};

/* Findings of one thread. `first` is leaf · 512 + voxel, or, past all leaves, a tile. */
typedef struct tally {
  float max;
  uint64_t counts[KIND_COUNT];
  uint64_t first[KIND_COUNT];
  float first_value[KIND_COUNT];
} tally;

typedef struct import {
  np_sparse_grid *grid;
  float max; /* of the finite values */
  tally *tallies;
} import;

static kind classify(float value, float max) {
  uint32_t bits, magnitude;
  memcpy(&bits, &value, sizeof bits);
  magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return KIND_NAN;
  if (magnitude == 0x7f800000u) return KIND_INFINITE;
  if (magnitude == 0) return KIND_GOOD;
  if (magnitude < 0x00800000u) return KIND_SUBNORMAL;
  if (value > 0.0f) return KIND_GOOD;
  return value < -rounding_of_max * max ? KIND_NEGATIVE : KIND_ROUNDING;
}

/* ---- Passes ---- */

static neph_result compute_max(void *user, size_t begin, size_t end, unsigned thread) {
  const import *i = user;
  float max = i->tallies[thread].max;
  for (size_t leaf = begin; leaf < end; leaf++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      float value = i->grid->leaves[leaf].values[n];
      if (value > max && value <= FLT_MAX) max = value;
    }
  i->tallies[thread].max = max;
  return NEPH_OK;
}

static void check_value(tally *t, float *value, float max, uint64_t place) {
  kind k = classify(*value, max);
  if (k == KIND_GOOD) return;
  if (!t->counts[k]++ || place < t->first[k]) {
    t->first[k] = place;
    t->first_value[k] = *value;
  }
  *value = 0.0f;
}

static neph_result check_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const import *i = user;
  for (size_t leaf = begin; leaf < end; leaf++)
    for (size_t n = 0; n < NP_LEAF_SIZE; n++)
      check_value(&i->tallies[thread], &i->grid->leaves[leaf].values[n], i->max, leaf * NP_LEAF_SIZE + n);
  return NEPH_OK;
}

static void check_tiles(const import *i) {
  for (size_t n = 0; n < i->grid->tile_count; n++)
    check_value(&i->tallies[0], &i->grid->tiles[n].value, i->max, i->grid->leaf_count * NP_LEAF_SIZE + n);
}

static void unite(tally *all, const tally *t) {
  for (int k = 0; k < KIND_COUNT; k++) {
    if (t->counts[k] && (!all->counts[k] || t->first[k] < all->first[k])) {
      all->first[k] = t->first[k];
      all->first_value[k] = t->first_value[k];
    }
    all->counts[k] += t->counts[k];
  }
}

/* ---- Report ---- */

static void compute_voxel(const np_sparse_grid *grid, uint64_t place, int32_t out_voxel[3]) {
  size_t leaf = place / NP_LEAF_SIZE, n = place % NP_LEAF_SIZE;
  bool is_tile = leaf >= grid->leaf_count;
  const int32_t *origin =
      is_tile ? grid->tiles[place - grid->leaf_count * NP_LEAF_SIZE].origin : grid->leaves[leaf].origin;
  const int32_t offset[3] = {(int32_t)(n >> 6), (int32_t)(n >> 3 & 7), (int32_t)(n & 7)};
  for (int a = 0; a < 3; a++) out_voxel[a] = origin[a] + (is_tile ? 0 : offset[a]);
}

static void report(neph_context *context, neph_log_level level, const char *path, const np_sparse_grid *grid,
                   const tally *t, kind k, const char *consequence) {
  int32_t voxel[3];
  compute_voxel(grid, t->first[k], voxel);
  np_log(context, level, "%s: grid '%s': %llu values are %s, the first (%g) at voxel (%d, %d, %d); %s", path,
         grid->name, (unsigned long long)t->counts[k], kind_names[k], (double)t->first_value[k], voxel[0], voxel[1],
         voxel[2], consequence);
}

/* One error for the first kind that is refused; one warning for each kind that is repaired. */
static neph_result decide(neph_context *context, const char *path, const np_sparse_grid *grid, const tally *t,
                          neph_import_policy policy) {
  for (kind k = KIND_NAN; k <= KIND_NEGATIVE; k++)
    if (t->counts[k] && policy == NEPH_IMPORT_REFUSE) {
      report(context, NEPH_LOG_ERROR, path, grid, t, k, "must be finite and not negative, or be imported with repair");
      return NEPH_ERROR_BAD_FILE;
    }
  for (kind k = KIND_NAN; k < KIND_COUNT; k++)
    if (t->counts[k]) report(context, NEPH_LOG_WARNING, path, grid, t, k, "taken as 0");
  return NEPH_OK;
}

neph_result np_volume_import_values(neph_context *context, const char *path, np_sparse_grid *grid,
                                    neph_import_policy policy, np_monitor *monitor) {
import i = {.grid = grid };
  tally all = {0};
  i.tallies = np_alloc(context, context->thread_count, sizeof *i.tallies);
  if (!i.tallies) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(monitor, "checking values");
  np_monitor_set_range(monitor, 0.0, 0.3);
  neph_result result = np_parallel_for(context, monitor, grid->leaf_count, LEAVES_PER_PIECE, compute_max, &i);
  for (unsigned n = 0; n < context->thread_count; n++) i.max = fmaxf(i.max, i.tallies[n].max);
  for (size_t n = 0; n < grid->tile_count; n++)
    if (grid->tiles[n].value <= FLT_MAX) i.max = fmaxf(i.max, grid->tiles[n].value);
  np_monitor_set_range(monitor, 0.3, 1.0);
  if (!result) result = np_parallel_for(context, monitor, grid->leaf_count, LEAVES_PER_PIECE, check_leaves, &i);
  if (!result) check_tiles(&i);
  for (unsigned n = 0; n < context->thread_count; n++) unite(&all, &i.tallies[n]);
  if (!result) result = decide(context, path, grid, &all, policy);
  np_alloc_free(context, i.tallies);
  return result;
}
