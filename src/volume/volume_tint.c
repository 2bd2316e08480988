/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_tint.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/grid_reader.h"
#include "volume/volume_split.h"

enum { CORNERS = NP_TINT_PARTS_MAX };

/* Least share of a corner. Colours differ by no less in half precision; smaller shares go to the largest. */
static const float least_share = 0x1p-11f;

/* Counts and colour range of a thread's voxels. */
typedef struct color_tally {
  uint64_t voxels, clamped, outside;
  float low[3], high[3];
  unsigned corners; /* bit mask of the corners in use */
} color_tally;

/* Colours of a block of 8³ voxels. */
typedef struct color_block {
  float color[3][NP_LEAF_SIZE];
} color_block;

typedef struct tint_build {
  neph_context *context;
  const np_tint_source *source;
  np_monitor *monitor;
  np_split split;
  np_sparse_grid color[3];
  np_affine to_color[3]; /* maps from index positions of the density */
  color_block *blocks;   /* one for each of the split's */
  color_tally *tallies;  /* one for each thread */
  color_tally all;
} tint_build;

/* ---- Colours ---- */

static void read_color(const tint_build *b, np_grid_reader readers[3], size_t i, int n, color_tally *tally) {
  color_block *block = &b->blocks[i];
  bool is_inside = true, is_clamped = false;
  const np_dvec3 index = np_split_get_index(&b->split, i, n);
  for (int c = 0; c < 3; c++) {
    float value;
    is_inside = np_grid_read_between(&readers[c], np_affine_point(&b->to_color[c], index), &value) && is_inside;
    block->color[c][n] = np_clampf(value, 0.0f, 1.0f);
    is_clamped = is_clamped || block->color[c][n] != value;
    tally->low[c] = fminf(tally->low[c], block->color[c][n]);
    tally->high[c] = fmaxf(tally->high[c], block->color[c][n]);
  }
  tally->voxels++;
  tally->clamped += is_clamped;
  tally->outside += !is_inside;
}

static neph_result read_blocks(void *user, size_t begin, size_t end, unsigned thread) {
  const tint_build *b = user;
  np_grid_reader readers[3] = {{.grid = &b->color[0]}, {.grid = &b->color[1]}, {.grid = &b->color[2]}};
  for (size_t i = begin; i < end; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (np_split_get_density(&b->split, i, n) > 0.0f) read_color(b, readers, i, n, &b->tallies[thread]);
  return NEPH_OK;
}

static void unite_tallies(tint_build *b) {
  for (unsigned i = 0; i < b->context->thread_count; i++) {
    const color_tally *t = &b->tallies[i];
    b->all.voxels += t->voxels;
    b->all.clamped += t->clamped;
    b->all.outside += t->outside;
    b->all.corners |= t->corners;
    for (int c = 0; c < 3 && t->voxels; c++) {
      b->all.low[c] = fminf(b->all.low[c], t->low[c]);
      b->all.high[c] = fmaxf(b->all.high[c], t->high[c]);
    }
  }
}

static void warn(const tint_build *b) {
  const color_tally *t = &b->all;
  const np_sparse_grid *c = b->color;
  if (t->clamped)
    np_log(b->context, NEPH_LOG_WARNING,
           "%s: grid '%s': the colours of %llu voxels are not in [0, 1], as a share of the albedo must be; clamped",
           b->source->path, c->name, (unsigned long long)t->clamped);
  if (t->outside)
    np_log(b->context, NEPH_LOG_WARNING,
           "%s: grid '%s' ends before the cloud: %llu of %llu voxels have its background, (%g, %g, %g)",
           b->source->path, c->name, (unsigned long long)t->outside, (unsigned long long)t->voxels,
           (double)c[0].background, (double)c[1].background, (double)c[2].background);
}

static neph_result start_tallies(tint_build *b) {
  const color_tally none = {.low = {1.0f, 1.0f, 1.0f}};
  b->tallies = np_alloc(b->context, b->context->thread_count, sizeof *b->tallies);
  if (!b->tallies) return NEPH_ERROR_OUT_OF_MEMORY;
  b->all = none;
  for (unsigned i = 0; i < b->context->thread_count; i++) b->tallies[i] = none;
  return NEPH_OK;
}

static neph_result read_colors(tint_build *b) {
  const neph_volume *density = b->source->density;
  for (int c = 0; c < 3; c++) {
    np_affine to_index;
    if (!np_affine_invert(&b->color[c].index_to_world, &to_index))
      return np_fail(b->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s': its transform cannot be inverted",
                     b->source->path, b->color[c].name);
    b->to_color[c] = np_affine_compose(&to_index, &density->index_to_world);
  }
  neph_result result = start_tallies(b);
  if (!result) result = np_parallel_for(b->context, b->monitor, b->split.block_count, 16, read_blocks, b);
  if (result) return result;
  unite_tallies(b);
  warn(b);
  for (int c = 0; c < 3; c++)
    if (b->all.high[c] - b->all.low[c] < least_share)
      b->all.low[c] = b->all.high[c] = 0.5f * (b->all.low[c] + b->all.high[c]);
  return NEPH_OK;
}

/* ---- Shares ---- */

/* Tetrahedral interpolation: shares of the box's corners in a colour. The corners are those of the tetrahedron around
 * it, by the order of its channels. A corner's bits are the channels that are high. */
static void compute_shares(const void *user, size_t i, int n, float out[CORNERS]) {
  const tint_build *b = user;
  const color_block *block = &b->blocks[i];
  float place[3];
  int order[3] = {0, 1, 2};
  for (int c = 0; c < 3; c++) {
    const float low = b->all.low[c], range = b->all.high[c] - low;
    place[c] = range > 0.0f ? (block->color[c][n] - low) / range : 0.0f;
    assert(place[c] >= 0.0f && place[c] <= 1.0f + 1e-6f);
  }
  for (int c = 1; c < 3; c++)
    for (int k = c; k > 0 && place[order[k]] > place[order[k - 1]]; k--) {
      const int other = order[k];
      order[k] = order[k - 1];
      order[k - 1] = other;
    }
  memset(out, 0, CORNERS * sizeof *out);
  unsigned corner = 0, largest = 0;
  float before = 1.0f;
  for (int k = 0; k <= 3; k++) {
    const float after = k < 3 ? place[order[k]] : 0.0f;
    out[corner] += before - after;
    before = after;
    if (out[corner] > out[largest]) largest = corner;
    if (k < 3) corner |= 1u << order[k];
  }
  for (unsigned k = 0; k < CORNERS; k++)
    if (k != largest && out[k] < least_share) {
      out[largest] += out[k];
      out[k] = 0.0f;
    }
}

static neph_result add_corners(void *user, size_t begin, size_t end, unsigned thread) {
  const tint_build *b = user;
  float shares[CORNERS];
  for (size_t i = begin; i < end; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      if (!(np_split_get_density(&b->split, i, n) > 0.0f)) continue;
      compute_shares(b, i, n, shares);
      for (unsigned k = 0; k < CORNERS; k++)
        if (shares[k] > 0.0f) b->tallies[thread].corners |= 1u << k;
    }
  return NEPH_OK;
}

/* ---- Parts ---- */

static neph_result build_part(const tint_build *b, unsigned corner, np_tint *out) {
  np_tint_part *part = &out->parts[out->count];
  for (int c = 0; c < 3; c++) part->color[c] = (double)(corner >> c & 1 ? b->all.high[c] : b->all.low[c]);
  if (b->all.corners == 1u << corner) {
    out->count++;
    return NEPH_OK;
  }
  const neph_result result = np_split_make_part(&b->split, corner, &part->volume);
  out->count += !result;
  return result;
}

static neph_result build_parts(tint_build *b, np_tint *out) {
  neph_result result = np_parallel_for(b->context, b->monitor, b->split.block_count, 16, add_corners, b);
  unite_tallies(b);
  for (unsigned k = 0; k < CORNERS && !result; k++)
    if (b->all.corners >> k & 1u) result = build_part(b, k, out);
  return result;
}

/* ---- Entry ---- */

static bool is_empty(const tint_build *b) {
  bool is_empty = true;
  for (int c = 0; c < 3; c++) is_empty = is_empty && np_sparse_grid_count_active(&b->color[c]) == 0;
  if (is_empty)
    np_log(b->context, NEPH_LOG_WARNING, "%s: grid '%s' is empty: it has no active voxels", b->source->path,
           b->color[0].name);
  return is_empty;
}

static neph_result build(tint_build *b, np_tint *out) {
  neph_result result = np_split_start(&b->split, b->source->path, "color");
  if (!result) b->blocks = np_alloc(b->context, b->split.block_count, sizeof *b->blocks);
  if (!result) result = b->blocks ? read_colors(b) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && b->all.voxels > 0) result = build_parts(b, out);
  if (!result)
    np_log(b->context, NEPH_LOG_INFO, "%s: grid '%s': colours from (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g), as %u %s",
           b->source->path, b->color[0].name, (double)b->all.low[0], (double)b->all.low[1], (double)b->all.low[2],
           (double)b->all.high[0], (double)b->all.high[1], (double)b->all.high[2], out->count,
           out->count == 1 ? "cloud" : "clouds of one colour each");
  np_alloc_free(b->context, b->tallies);
  np_alloc_free(b->context, b->blocks);
  np_split_clear(&b->split);
  return result;
}

static neph_result create(tint_build *b, np_tint **out_tint) {
  np_tint *tint = np_alloc(b->context, 1, sizeof *tint);
  if (!tint) return NEPH_ERROR_OUT_OF_MEMORY;
  tint->context = b->context;
  const neph_result result = build(b, tint);
  if (!result && tint->count > 0)
    *out_tint = tint;
  else
    np_tint_destroy(tint);
  return result;
}

neph_result np_tint_create(neph_context *context, const np_tint_source *source, np_monitor *monitor,
                           np_tint **out_tint) {
  tint_build b = {.context = context, .source = source, .monitor = monitor};
  b.split = (np_split){.context = context,
                       .density = source->density,
                       .precision = source->load->precision,
                       .monitor = monitor,
                       .compute_shares = compute_shares,
                       .user = &b};
  const np_vector_request request = {NP_VECTOR_COLOR, source->color, source->load->policy};
  bool is_found;
  *out_tint = NULL;
  neph_result result = np_volume_load_vector(context, source->path, &request, monitor, b.color, &is_found);
  if (!result && is_found && !is_empty(&b)) result = create(&b, out_tint);
  for (int c = 0; c < 3; c++) np_sparse_grid_clear(&b.color[c]);
  return result;
}

neph_result np_tint_create_levels(neph_context *context, np_volume_parts kind, np_tint **out_tint) {
  np_tint *tint = *out_tint = np_alloc(context, 1, sizeof *tint);
  if (!tint) return NEPH_ERROR_OUT_OF_MEMORY;
  *tint = (np_tint){.context = context, .count = 1, .kind = kind, .parts = {{.color = {1, 1, 1}}}};
  return NEPH_OK;
}

void np_tint_add_level(np_tint *tint, neph_volume *level) {
  tint->parts[tint->count++] = (np_tint_part){.volume = level, .color = {1, 1, 1}};
}
