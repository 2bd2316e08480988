/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/value_tally.h"

#include <float.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/frustum.h"

enum { LEAVES_PER_PIECE = 64 };

/* Negative values up to this share of the largest value count as rounding errors of 0. */
static const float rounding_of_max = 1e-6f;

const char *const np_value_kind_names[NP_VALUE_KINDS] = {"NaN", "infinite", "negative", "negative by rounding",
                                                         "subnormal"};

typedef struct tally_job {
  np_sparse_grid *grid; /* changed if values are repaired */
  np_value_rule rule;
  bool is_repaired;
  float max; /* largest finite value */
  np_value_tally *tallies;
  bool *is_plain; /* one for each leaf: all its values are valid */
} tally_job;

static np_value_kind classify(np_value_rule rule, float value, float max) {
  uint32_t bits, magnitude;
  memcpy(&bits, &value, sizeof bits);
  magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return NP_VALUE_NAN;
  if (magnitude == 0x7f800000u) return NP_VALUE_INFINITE;
  if (magnitude == 0 || rule == NP_VALUES_OF_VECTOR) return NP_VALUE_GOOD;
  if (magnitude < 0x00800000u) return NP_VALUE_SUBNORMAL;
  if (value > 0.0f) return NP_VALUE_GOOD;
  return value < -rounding_of_max * max ? NP_VALUE_NEGATIVE : NP_VALUE_ROUNDING;
}

bool np_values_are_distances(float background, float value_min) {
  return background > 0.0f && value_min <= -0.5f * background && value_min >= -1.001f * background;
}

/* ---- Passes ---- */

/* Bits of the smallest normal number and of infinity: the bits of plain values are 0 or between the two. */
static const int32_t normal_bits = 0x00800000, infinity_bits = 0x7f800000;

/* Whether a leaf holds plain values only, and their maximum. */
static bool is_plain(const float values[NP_LEAF_SIZE], float *out_max) {
  enum { LANES = 8 };
  int32_t max[LANES] = {0}, odd[LANES] = {0};
  for (int row = 0; row < NP_LEAF_SIZE; row += LANES)
    for (int k = 0; k < LANES; k++) {
      int32_t bits;
      memcpy(&bits, &values[row + k], sizeof bits);
      max[k] = bits > max[k] ? bits : max[k];
      odd[k] |= (bits < normal_bits) & (bits != 0);
    }
  for (int k = 1; k < LANES; k++) {
    max[0] = max[k] > max[0] ? max[k] : max[0];
    odd[0] |= odd[k];
  }
  memcpy(out_max, &max[0], sizeof *out_max);
  return !odd[0] && max[0] < infinity_bits;
}

static float get_finite_max(const float values[NP_LEAF_SIZE]) {
  float max = 0.0f;
  for (int n = 0; n < NP_LEAF_SIZE; n++)
    if (values[n] > max && values[n] <= FLT_MAX) max = values[n];
  return max;
}

static neph_result compute_max(void *user, size_t begin, size_t end, unsigned thread) {
  const tally_job *job = user;
  for (size_t leaf = begin; leaf < end; leaf++) {
    const float *values = job->grid->leaves[leaf].values;
    float max;
    job->is_plain[leaf] = is_plain(values, &max);
    if (!job->is_plain[leaf]) max = get_finite_max(values);
    job->tallies[thread].max = fmaxf(job->tallies[thread].max, max);
  }
  return NEPH_OK;
}

/* Repaired value: infinity becomes the largest finite value, for it was above the range of the file. */
static float repair(const tally_job *job, np_value_kind kind, float value, bool is_active) {
  const bool is_above_all = kind == NP_VALUE_INFINITE && value > 0.0f && job->rule == NP_VALUES_OF_CLOUD;
  return is_above_all && is_active ? job->max : 0.0f;
}

static void count_value(const tally_job *job, np_value_tally *t, float *value, bool is_active, uint64_t place) {
  const np_value_kind k = classify(job->rule, *value, job->max);
  if (k == NP_VALUE_GOOD) return;
  if (!t->counts[k]++ || place < t->first[k]) {
    t->first[k] = place;
    t->first_value[k] = *value;
  }
  if (job->is_repaired) *value = repair(job, k, *value, is_active);
}

static neph_result count_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const tally_job *job = user;
  for (size_t i = begin; i < end; i++) {
    np_leaf *leaf = &job->grid->leaves[i];
    for (size_t n = 0; n < NP_LEAF_SIZE && !job->is_plain[i]; n++)
      count_value(job, &job->tallies[thread], &leaf->values[n], leaf->active[n / 64] >> (n % 64) & 1u,
                  i * NP_LEAF_SIZE + n);
  }
  return NEPH_OK;
}

static void count_tiles(const tally_job *job) {
  for (size_t n = 0; n < job->grid->tile_count; n++) {
    np_tile *tile = &job->grid->tiles[n];
    count_value(job, &job->tallies[0], &tile->value, tile->is_active, job->grid->leaf_count * NP_LEAF_SIZE + n);
  }
}

static void unite(np_value_tally *all, const np_value_tally *t) {
  for (int k = 0; k < NP_VALUE_KINDS; k++) {
    if (t->counts[k] && (!all->counts[k] || t->first[k] < all->first[k])) {
      all->first[k] = t->first[k];
      all->first_value[k] = t->first_value[k];
    }
    all->counts[k] += t->counts[k];
  }
}

static neph_result count_all(tally_job *job, np_monitor *monitor) {
  neph_context *context = job->grid->context;
  np_monitor_set_stage(monitor, "checking values");
  np_monitor_set_range(monitor, 0.0, 0.3);
  neph_result result = np_parallel_for(context, monitor, job->grid->leaf_count, LEAVES_PER_PIECE, compute_max, job);
  for (unsigned n = 0; n < context->thread_count; n++) job->max = fmaxf(job->max, job->tallies[n].max);
  for (size_t n = 0; n < job->grid->tile_count; n++)
    if (job->grid->tiles[n].value <= FLT_MAX) job->max = fmaxf(job->max, job->grid->tiles[n].value);
  np_monitor_set_range(monitor, 0.3, 1.0);
  if (!result) result = np_parallel_for(context, monitor, job->grid->leaf_count, LEAVES_PER_PIECE, count_leaves, job);
  if (!result) count_tiles(job);
  return result;
}

neph_result np_value_tally_count(np_sparse_grid *grid, np_value_rule rule, bool is_repaired, np_monitor *monitor,
                                 np_value_tally *out_tally) {
  neph_context *context = grid->context;
  tally_job job = {.grid = grid, .rule = rule, .is_repaired = is_repaired};
  *out_tally = (np_value_tally){0};
  job.tallies = np_alloc(context, context->thread_count, sizeof *job.tallies);
  job.is_plain = np_alloc(context, grid->leaf_count + 1, sizeof *job.is_plain);
  neph_result result = job.tallies && job.is_plain ? count_all(&job, monitor) : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned n = 0; n < context->thread_count && job.tallies; n++) unite(out_tally, &job.tallies[n]);
  out_tally->max = job.max;
  np_alloc_free(context, job.is_plain);
  np_alloc_free(context, job.tallies);
  return result;
}

/* ---- Places ---- */

void np_value_tally_locate(const np_sparse_grid *grid, uint64_t place, np_value_place *out_place) {
  const size_t leaf = place / NP_LEAF_SIZE, n = place % NP_LEAF_SIZE;
  const bool is_tile = leaf >= grid->leaf_count;
  const int32_t *origin =
      is_tile ? grid->tiles[place - grid->leaf_count * NP_LEAF_SIZE].origin : grid->leaves[leaf].origin;
  const int32_t offset[3] = {(int32_t)(n >> 6), (int32_t)(n >> 3 & 7), (int32_t)(n & 7)};
  for (int a = 0; a < 3; a++) out_place->voxel[a] = origin[a] + (is_tile ? 0 : offset[a]);
  const np_dvec3 index = np_dvec3_make(out_place->voxel[0], out_place->voxel[1], out_place->voxel[2]);
  const np_dvec3 at = grid->frustum.is_enabled ? np_frustum_map_point(&grid->frustum, index)
                                               : np_affine_point(&grid->index_to_world, index);
  out_place->world_m[0] = at.x, out_place->world_m[1] = at.y, out_place->world_m[2] = at.z;
}
