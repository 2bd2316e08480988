/* SPDX-License-Identifier: Apache-2.0 */
/* Baking: samples the density model on leaves of 8³ voxels, only where there may be cloud.
 *
 * First a bound, which needs no noise, is evaluated for every leaf of the field's box. Leaves that may hold cloud are
 * listed in the grid's order, evaluated in parallel in batches that fill one buffer, and appended in that order if they
 * hold cloud: the grid does not depend on the number of threads. */
#include "cloud/bake_grid.h"

#include <immintrin.h>
#include <math.h>
#include <string.h>

#include <nephos/volume.h>

#include "cloud/bake_field.h"
#include "cloud/bake_lod.h"
#include "cloud/bake_memory.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_name.h"
#include "core/alloc.h"
#include "volume/volume_private.h"

enum {
  BATCH_LEAVES = 2048,
  SAMPLE_LEAVES = 512,     /* most that are evaluated first as a sample, in the same buffer, … */
  SAMPLE_LEAVES_FEW = 64,  /* … all of so few, … */
  SAMPLE_LEAVES_EACH = 16, /* … and of others one in so many */
};

#define CLOUD_LEAVES_MAX (UINT64_C(1) << 23) /* leaves that may hold cloud: 17 GB */

typedef struct leaf_origin {
  int32_t index[3];
} leaf_origin;

typedef struct bake_job {
  const np_bake *bake;
  float prune_per_m;
  np_bake_marks marks;
  leaf_origin *origins; /* origins of the batch */
  np_leaf *leaves;
} bake_job;

/* ---- Evaluating leaves ---- */

/* Lists the positions of a leaf's voxels; values of a column are computed once. */
static void list_points(const np_bake *bake, const leaf_origin *origin, np_bake_points *points) {
  double x_m[NP_LEAF_EDGE], y_m[NP_LEAF_EDGE], z_m[NP_LEAF_EDGE];
  for (int32_t n = 0; n < NP_LEAF_EDGE; n++) {
    x_m[n] = np_bake_compute_offset_m(bake, 0, origin->index[0] + n);
    y_m[n] = np_bake_compute_offset_m(bake, 1, origin->index[1] + n);
    z_m[n] = np_bake_compute_offset_m(bake, 2, origin->index[2] + n);
  }
  points->count = NP_LEAF_SIZE;
  for (int n = 0; n < NP_LEAF_SIZE; n += NP_LEAF_EDGE) {
    const double x = x_m[n / 64], y = y_m[n / 8 % 8];
    float *height_m = points->height_m + n;
    for (int k = 0; k < NP_LEAF_EDGE; k++) {
      const double offset_m[3] = {x, y, z_m[k]};
      points->x_m[n + k] = (float)x;
      points->y_m[n + k] = (float)y;
      height_m[k] = (float)np_bake_compute_height_m(bake, offset_m);
    }
  }
}

/* Mask of a leaf's voxels inside the region. */
static uint64_t compute_row_mask(const np_bake *bake, const leaf_origin *origin, int32_t i) {
  uint64_t row = 0;
  if (origin->index[0] + i < bake->region_min[0] || origin->index[0] + i > bake->region_max[0]) return 0;
  for (int32_t n = 0; n < 64; n++) {
    const int32_t y = origin->index[1] + n / 8, z = origin->index[2] + n % 8;
    const bool is_inside =
        y >= bake->region_min[1] && y <= bake->region_max[1] && z >= bake->region_min[2] && z <= bake->region_max[2];
    row |= (uint64_t)is_inside << n;
  }
  return row;
}

/* Bit mask of 64 values above a limit. */
static uint64_t compute_mask_above(const float *values, float limit) {
  uint64_t above = 0;
  for (int n = 0; n < 64; n += 4)
    above |= (uint64_t)_mm_movemask_ps(_mm_cmpgt_ps(_mm_loadu_ps(values + n), _mm_set1_ps(limit))) << n;
  return above;
}

/* Whether voxels of a leaf may be outside of the bake. */
static bool is_cut(const np_bake *bake) { return bake->desc.has_region || bake->model.desc.repeat_m > 0; }

static void clear_values(float *values, uint64_t kept) {
  for (int n = 0; n < 64; n++) values[n] = kept >> n & 1u ? values[n] : 0.0f;
}

/* Finishes one slice of a leaf: remaining voxels become active, others 0. */
static void finish_slice(const bake_job *job, const leaf_origin *origin, int32_t i, np_leaf *leaf) {
  float *values = leaf->values + 64 * i;
  const uint64_t cloudy = compute_mask_above(values, 0.0f);
  uint64_t kept = compute_mask_above(values, job->prune_per_m);
  if (is_cut(job->bake)) kept &= compute_row_mask(job->bake, origin, i);
  if (kept != cloudy) clear_values(values, kept);
  leaf->active[i] = kept;
}

/* Voxels of a leaf that are evaluated together. */
typedef struct leaf_batch {
  np_bake_points points;
  int voxel[NP_LEAF_SIZE];
} leaf_batch;

static void eval_batch(const bake_job *job, const np_bake_points *of, leaf_batch *batch, np_leaf *leaf) {
  float values[NP_LEAF_SIZE];
  for (size_t i = 0; i < batch->points.count; i++) {
    batch->points.x_m[i] = of->x_m[batch->voxel[i]];
    batch->points.y_m[i] = of->y_m[batch->voxel[i]];
    batch->points.height_m[i] = of->height_m[batch->voxel[i]];
  }
  np_bake_eval(&job->bake->model, &batch->points, values);
  for (size_t i = 0; i < batch->points.count; i++) leaf->values[batch->voxel[i]] = values[i];
}

/* Evaluates the samples of a leaf of another level that the cells before it share: its first planes. They are inactive.
 */
static void eval_border(const bake_job *job, const leaf_origin *origin, const np_bake_points *points, np_leaf *leaf) {
  leaf_batch batch;
  size_t count = 0;
  memset(leaf, 0, sizeof *leaf);
  for (int n = 0; n < NP_LEAF_SIZE; n++)
    if (n / 64 == 0 || n / 8 % 8 == 0 || n % 8 == 0) batch.voxel[count++] = n;
  batch.points.count = count;
  eval_batch(job, points, &batch, leaf);
  for (int32_t i = 0; i < NP_LEAF_EDGE && is_cut(job->bake); i++)
    clear_values(leaf->values + 64 * i, compute_row_mask(job->bake, origin, i));
}

static void eval_leaf(const bake_job *job, const leaf_origin *origin, np_leaf *leaf) {
  np_bake_points points;
  list_points(job->bake, origin, &points);
  if (job->bake->lod.count > 1 && !np_bake_owns_leaf(job->bake, origin->index)) {
    eval_border(job, origin, &points, leaf);
  } else {
    np_bake_eval(&job->bake->model, &points, leaf->values);
    for (int32_t i = 0; i < NP_LEAF_EDGE; i++) finish_slice(job, origin, i, leaf);
  }
  memcpy(leaf->origin, origin->index, sizeof leaf->origin);
}

/* Whether a leaf has values; leaves of borders have inactive ones. */
static bool has_any(const np_leaf *leaf) {
  for (int i = 0; i < NP_LEAF_EDGE; i++)
    if (leaf->active[i] || compute_mask_above(leaf->values + 64 * i, 0.0f)) return true;
  return false;
}

static neph_result eval_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  bake_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) eval_leaf(job, &job->origins[i], &job->leaves[i]);
  return NEPH_OK;
}

/* ---- Search for leaves ---- */

/* Box of a leaf's samples in model coordinates. Heights range from the lowest sample nearest to the planet's axis to
 * the highest sample farthest from it. */
static np_cloud_box compute_box(const np_bake *bake, const leaf_origin *origin) {
  np_cloud_box box;
  double nearest_m[3], farthest_m[3];
  for (int a = 0; a < 2; a++) {
    const double low = np_bake_compute_offset_m(bake, a, origin->index[a]);
    const double high = np_bake_compute_offset_m(bake, a, origin->index[a] + NP_LEAF_EDGE - 1);
    const double center_m = bake->model.desc.center_m[a];
    nearest_m[a] = center_m + low > 0 ? low : center_m + high < 0 ? high : -center_m;
    farthest_m[a] = fabs(center_m + low) > fabs(center_m + high) ? low : high;
    box.min_m[a] = (float)low;
    box.max_m[a] = (float)high;
  }
  nearest_m[2] = np_bake_compute_offset_m(bake, 2, origin->index[2]);
  farthest_m[2] = np_bake_compute_offset_m(bake, 2, origin->index[2] + NP_LEAF_EDGE - 1);
  box.min_m[2] = (float)np_bake_compute_height_m(bake, nearest_m);
  box.max_m[2] = (float)np_bake_compute_height_m(bake, farthest_m);
  return box;
}

static leaf_origin compute_origin(const np_bake *bake, size_t leaf) {
  const size_t nz = (size_t)bake->leaf_count[2], ny = (size_t)bake->leaf_count[1];
  const int32_t at[3] = {(int32_t)(leaf / nz / ny), (int32_t)(leaf / nz % ny), (int32_t)(leaf % nz)};
  leaf_origin origin;
  for (int a = 0; a < 3; a++) origin.index[a] = (at[a] + bake->leaf_begin[a]) * NP_LEAF_EDGE;
  return origin;
}

static neph_result mark_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  bake_job *job = user;
  (void)thread;
  for (size_t leaf = begin; leaf < end; leaf++) {
    const leaf_origin origin = compute_origin(job->bake, leaf);
    const np_cloud_box box = compute_box(job->bake, &origin);
    job->marks.is_cloudy[leaf] = (job->bake->lod.count == 1 || np_bake_needs_leaf(job->bake, origin.index)) &&
                                 !np_cloud_model_is_empty(&job->bake->model, &box);
  }
  return NEPH_OK;
}

/* Estimates the number of marked leaves with cloud from an evenly spread sample. */
static neph_result sample_share(bake_job *job) {
  const size_t box_count = np_bake_count_box(job->bake), marked = job->marks.cloudy_count;
  const size_t few = marked < SAMPLE_LEAVES_FEW ? marked : SAMPLE_LEAVES_FEW, part = marked / SAMPLE_LEAVES_EACH;
  const size_t wanted = part < few ? few : part < SAMPLE_LEAVES ? part : SAMPLE_LEAVES;
  size_t count = 0, seen = 0, filled = 0;
  for (size_t leaf = 0; leaf < box_count && count < wanted; leaf++) {
    if (!job->marks.is_cloudy[leaf]) continue;
    if (seen++ == count * marked / wanted) job->origins[count++] = compute_origin(job->bake, leaf);
  }
  neph_result result = np_parallel_for(job->bake->context, job->bake->monitor, count, 4, eval_leaves, job);
  for (size_t i = 0; i < count; i++) filled += has_any(&job->leaves[i]);
  job->marks.share = count ? (double)filled / (double)count : 0;
  return result;
}

static neph_result mark_all_cloudy(bake_job *job) {
  const np_bake *bake = job->bake;
  const size_t count = np_bake_count_box(bake);
  np_monitor_set_range(bake->monitor, 0.0, 0.05);
  neph_result result = np_parallel_for(bake->context, bake->monitor, count, 1024, mark_leaves, job);
  if (result) return result;
  for (size_t i = 0; i < count; i++) job->marks.cloudy_count += job->marks.is_cloudy[i];
  if (job->marks.cloudy_count > CLOUD_LEAVES_MAX)
    return np_fail(
        bake->context, NEPH_ERROR_LIMIT,
        "%s: %zu leaves of 8³ voxels (%.1f GB) may hold cloud, must be at most %llu: enlarge voxel, which is "
        "%g m, or reduce extent",
        np_cloud_desc_name(&bake->model.desc), job->marks.cloudy_count,
        (double)job->marks.cloudy_count * sizeof(np_leaf) * 1e-9, (unsigned long long)CLOUD_LEAVES_MAX, bake->voxel_m);
  result = sample_share(job);
  return result ? result : np_bake_check_memory(bake, &job->marks);
}

/* ---- The grid ---- */

static neph_result append_leaves(np_sparse_grid *grid, const np_leaf *leaves, size_t count) {
  for (size_t i = 0; i < count; i++) {
    if (!has_any(&leaves[i])) continue;
    np_leaf *leaf = np_sparse_grid_add_leaf(grid, leaves[i].origin);
    if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
    *leaf = leaves[i];
  }
  return NEPH_OK;
}

/* Evaluates the marked leaves in batches. Room for all is allocated at once: growing would copy, and untouched pages
 * cost nothing. */
static neph_result bake_leaves(bake_job *job, np_sparse_grid *grid) {
  const np_bake *bake = job->bake;
  const size_t box_count = np_bake_count_box(bake), cloudy_count = job->marks.cloudy_count;
  size_t done = 0;
  neph_result result = np_sparse_grid_reserve(grid, cloudy_count, 0);
  for (size_t leaf = 0; done < cloudy_count && !result;) {
    size_t count = 0;
    for (; leaf < box_count && count < BATCH_LEAVES; leaf++)
      if (job->marks.is_cloudy[leaf]) job->origins[count++] = compute_origin(bake, leaf);
    np_monitor_set_range(bake->monitor, 0.05 + 0.95 * (double)done / (double)cloudy_count,
                         0.05 + 0.95 * (double)(done + count) / (double)cloudy_count);
    result = np_parallel_for(bake->context, bake->monitor, count, 4, eval_leaves, job);
    if (!result) result = append_leaves(grid, job->leaves, count);
    done += count;
  }
  return result;
}

static neph_result fill_grid(const np_bake *bake, np_sparse_grid *grid) {
  neph_context *context = bake->context;
  if (np_bake_count_box(bake) == 0) return NEPH_OK;
  bake_job job = {.bake = bake, .prune_per_m = bake->desc.error ? 0.0f : (float)bake->desc.prune_per_m};
  job.marks.is_cloudy = np_alloc(context, np_bake_count_box(bake), sizeof *job.marks.is_cloudy);
  job.origins = np_alloc(context, BATCH_LEAVES, sizeof *job.origins);
  job.leaves = np_alloc(context, BATCH_LEAVES, sizeof *job.leaves);
  neph_result result = job.marks.is_cloudy && job.origins && job.leaves ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = mark_all_cloudy(&job);
  if (!result) result = bake_leaves(&job, grid);
  np_alloc_free(context, job.leaves);
  np_alloc_free(context, job.origins);
  np_alloc_free(context, job.marks.is_cloudy);
  return result;
}

neph_result np_bake_make_grid(np_bake *bake, const char *name, np_sparse_grid *out_grid) {
  np_monitor_set_stage(bake->monitor, "baking");
  neph_result result = np_sparse_grid_init(bake->context, name, out_grid);
  if (result) return result;
  out_grid->index_to_world = np_bake_compute_transform(bake);
  result = fill_grid(bake, out_grid);
  if (result) np_sparse_grid_clear(out_grid);
  return result;
}

void np_bake_prune(const np_bake *bake, np_sparse_grid *grid) {
  const float prune_per_m = (float)bake->desc.prune_per_m;
  size_t kept = 0;
  for (size_t i = 0; i < grid->leaf_count; i++) {
    np_leaf *leaf = &grid->leaves[i];
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const bool is_active = leaf->active[n / 64] >> n % 64 & 1u;
      if (is_active && leaf->values[n] > prune_per_m) continue;
      leaf->values[n] = 0.0f;
      leaf->active[n / 64] &= ~(UINT64_C(1) << (n % 64));
    }
    if (has_any(leaf)) grid->leaves[kept++] = *leaf;
  }
  grid->leaf_count = kept;
}

neph_result np_cloud_bake_grid(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               const char *name, np_monitor *monitor, np_sparse_grid *out_grid) {
  np_bake bake;
  neph_result result = np_bake_start(context, cloud, desc, NP_BAKE_FOR_GRID, monitor, &bake);
  if (result) return result;
  result = np_bake_make_grid(&bake, name, out_grid);
  np_bake_end(&bake);
  return result;
}
