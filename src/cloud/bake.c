/* SPDX-License-Identifier: Apache-2.0 */
/* Baking: the density model sampled on leaves of 8³ voxels, only where there may be cloud.
 *
 * First every leaf of the field's box is asked for a bound, which costs no noise; those that may hold cloud are listed
 * in the grid's order. They are evaluated in parallel, in batches that fill one buffer, and appended in that order when
 * they do hold some, so that the grid does not depend on how many threads worked.
 */
#include <math.h>
#include <string.h>

#include <nephos/volume.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "volume/volume_private.h"

enum { BATCH_LEAVES = 2048 };

#define BOX_LEAVES_MAX (UINT64_C(1) << 27)   /* of the whole field, a byte each while their bounds are found */
#define CLOUD_LEAVES_MAX (UINT64_C(1) << 23) /* that may hold cloud: 17 GB */

typedef struct leaf_origin {
  int32_t index[3];
} leaf_origin;

typedef struct bake_job {
  neph_context *context;
  np_monitor *monitor;
  const np_cloud_model *model;
  double planet_radius_m, center_m[2];
  int32_t voxels[2];                    /* along x, y */
  int32_t leaf_begin[3], leaf_count[3]; /* the box to bake, in leaves */
  int32_t region_min[3], region_max[3]; /* voxels to bake, both ends inside */
  float prune_per_m;
  uint64_t memory_max_bytes;
  uint8_t *is_cloudy;   /* of each leaf of the box, z fastest: whether it may hold cloud */
  leaf_origin *origins; /* of the batch */
  np_leaf *leaves;
} bake_job;

/* Index to metres from the field's centre along x, y; from the base altitude along z. Samples sit in the middle of
 * voxels. */
static double find_offset_m(const bake_job *job, int axis, int32_t index) {
  double voxel_m = job->model->desc.voxel_m;
  return axis == 2 ? ((double)index + 0.5) * voxel_m : ((double)index - 0.5 * (job->voxels[axis] - 1)) * voxel_m;
}

static double find_height_m(const bake_job *job, double x_offset_m, double y_offset_m, double z_offset_m) {
  const double base_m = job->model->desc.base_altitude_m;
  const np_dvec3 p = {job->center_m[0] + x_offset_m, job->center_m[1] + y_offset_m, base_m + z_offset_m};
  return np_altitude(p, job->planet_radius_m) - base_m;
}

static void eval_leaf(const bake_job *job, const leaf_origin *origin, np_leaf *leaf) {
  float x[NP_LEAF_SIZE], y[NP_LEAF_SIZE], height[NP_LEAF_SIZE];
  size_t n = 0;
  for (int32_t i = 0; i < NP_LEAF_EDGE; i++)
    for (int32_t j = 0; j < NP_LEAF_EDGE; j++)
      for (int32_t k = 0; k < NP_LEAF_EDGE; k++, n++) {
        double dx = find_offset_m(job, 0, origin->index[0] + i), dy = find_offset_m(job, 1, origin->index[1] + j);
        x[n] = (float)dx;
        y[n] = (float)dy;
        height[n] = (float)find_height_m(job, dx, dy, find_offset_m(job, 2, origin->index[2] + k));
      }
  const np_cloud_points points = {NP_LEAF_SIZE, x, y, height};
  np_cloud_model_eval(job->model, &points, leaf->values);
  memcpy(leaf->origin, origin->index, sizeof leaf->origin);
  memset(leaf->active, 0, sizeof leaf->active);
  for (n = 0; n < NP_LEAF_SIZE; n++) {
    const int32_t at[3] = {(int32_t)(n / 64), (int32_t)(n / 8 % 8), (int32_t)(n % 8)};
    bool is_kept = leaf->values[n] > job->prune_per_m;
    for (int a = 0; a < 3; a++)
      is_kept =
          is_kept && origin->index[a] + at[a] >= job->region_min[a] && origin->index[a] + at[a] <= job->region_max[a];
    if (is_kept)
      leaf->active[n / 64] |= UINT64_C(1) << (n % 64);
    else
      leaf->values[n] = 0.0f;
  }
}

static neph_result eval_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  bake_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) eval_leaf(job, &job->origins[i], &job->leaves[i]);
  return NEPH_OK;
}

/* The box of a leaf's samples in the model's coordinates: its heights lie between that of the lowest sample nearest to
 * the axis of the planet and that of the highest sample farthest from it. */
static np_cloud_box find_box(const bake_job *job, const leaf_origin *origin) {
  np_cloud_box box;
  double nearest[2], farthest[2];
  for (int a = 0; a < 2; a++) {
    double low = find_offset_m(job, a, origin->index[a]), high = find_offset_m(job, a, origin->index[a] + 7);
    double world_low = job->center_m[a] + low, world_high = job->center_m[a] + high;
    nearest[a] = world_low > 0 ? low : world_high < 0 ? high : -job->center_m[a];
    farthest[a] = fabs(world_low) > fabs(world_high) ? low : high;
    box.min_m[a] = (float)low;
    box.max_m[a] = (float)high;
  }
  box.min_m[2] = (float)find_height_m(job, nearest[0], nearest[1], find_offset_m(job, 2, origin->index[2]));
  box.max_m[2] = (float)find_height_m(job, farthest[0], farthest[1], find_offset_m(job, 2, origin->index[2] + 7));
  return box;
}

static leaf_origin find_origin(const bake_job *job, size_t leaf) {
  const size_t nz = (size_t)job->leaf_count[2], ny = (size_t)job->leaf_count[1];
  const int32_t at[3] = {(int32_t)(leaf / nz / ny), (int32_t)(leaf / nz % ny), (int32_t)(leaf % nz)};
  leaf_origin origin;
  for (int a = 0; a < 3; a++) origin.index[a] = (at[a] + job->leaf_begin[a]) * NP_LEAF_EDGE;
  return origin;
}

static size_t count_box(const bake_job *job) {
  return (size_t)job->leaf_count[0] * (size_t)job->leaf_count[1] * (size_t)job->leaf_count[2];
}

static neph_result mark_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  bake_job *job = user;
  (void)thread;
  for (size_t leaf = begin; leaf < end; leaf++) {
    const leaf_origin origin = find_origin(job, leaf);
    const np_cloud_box box = find_box(job, &origin);
    job->is_cloudy[leaf] = !np_cloud_model_is_empty(job->model, &box);
  }
  return NEPH_OK;
}

static neph_result append_leaves(np_sparse_grid *grid, const np_leaf *leaves, size_t count) {
  static const uint64_t none[NP_LEAF_EDGE] = {0};
  for (size_t i = 0; i < count; i++) {
    if (memcmp(leaves[i].active, none, sizeof none) == 0) continue;
    np_leaf *leaf = np_sparse_grid_add_leaf(grid, leaves[i].origin);
    if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
    *leaf = leaves[i];
  }
  return NEPH_OK;
}

/* Evaluates the marked leaves, a batch at a time. */
static neph_result bake_leaves(bake_job *job, size_t cloudy_count, np_sparse_grid *grid) {
  const size_t box_count = count_box(job);
  size_t done = 0;
  neph_result result = NEPH_OK;
  for (size_t leaf = 0; done < cloudy_count && !result;) {
    size_t count = 0;
    for (; leaf < box_count && count < BATCH_LEAVES; leaf++)
      if (job->is_cloudy[leaf]) job->origins[count++] = find_origin(job, leaf);
    np_monitor_set_range(job->monitor, (double)done / (double)cloudy_count,
                         (double)(done + count) / (double)cloudy_count);
    result = np_parallel_for(job->context, job->monitor, count, 4, eval_leaves, job);
    if (!result) result = append_leaves(grid, job->leaves, count);
    done += count;
  }
  return result;
}

/* The grid, with what its growth leaves over, and OpenVDB's or the bricks' copy of it. */
static neph_result check_memory(const bake_job *job, size_t cloudy) {
  const double bytes =
      (double)cloudy * 2.2 * sizeof(np_leaf) + (double)BATCH_LEAVES * sizeof(np_leaf) + (double)count_box(job);
  np_log(job->context, NEPH_LOG_INFO, "cloud: at most %.3g GB for %zu leaves of 8³ voxels", bytes * 1e-9, cloudy);
  if (bytes <= (double)job->memory_max_bytes) return NEPH_OK;
  return np_fail(job->context, NEPH_ERROR_LIMIT,
                 "cloud: the bake may need %.3g GB, must be at most %.3g GB: enlarge voxel_m, which is %g, lessen "
                 "extent_m, or bake a region",
                 bytes * 1e-9, (double)job->memory_max_bytes * 1e-9, job->model->desc.voxel_m);
}

static neph_result find_cloudy(bake_job *job, size_t *out_count) {
  const size_t count = count_box(job);
  neph_result result = np_parallel_for(job->context, job->monitor, count, 1024, mark_leaves, job);
  if (result) return result;
  size_t cloudy = 0;
  for (size_t i = 0; i < count; i++) cloudy += job->is_cloudy[i];
  *out_count = cloudy;
  if (cloudy > CLOUD_LEAVES_MAX)
    return np_fail(
        job->context, NEPH_ERROR_LIMIT,
        "cloud: %zu leaves of 8³ voxels (%.1f GB) may hold cloud, must be at most %llu: enlarge voxel_m, which "
        "is %g, or lessen extent_m",
        cloudy, (double)cloudy * sizeof(np_leaf) * 1e-9, (unsigned long long)CLOUD_LEAVES_MAX,
        job->model->desc.voxel_m);
  return check_memory(job, cloudy);
}

/* Clips the box of leaves to those that hold voxels of the region. */
static neph_result clip_extent(const neph_cloud_desc *cloud, const neph_bake_desc *desc, bake_job *job) {
  for (int a = 0; a < 3; a++) {
    job->region_min[a] = job->leaf_begin[a] * NP_LEAF_EDGE;
    job->region_max[a] = (job->leaf_begin[a] + job->leaf_count[a]) * NP_LEAF_EDGE - 1;
    if (!desc->has_region) continue;
    const double first_m = a == 2 ? cloud->base_altitude_m + 0.5 * cloud->voxel_m
                                  : cloud->center_m[a] - 0.5 * (job->voxels[a] - 1) * cloud->voxel_m;
    const double low = ceil((desc->region_min_m[a] - first_m) / cloud->voxel_m);
    const double high = floor((desc->region_max_m[a] - first_m) / cloud->voxel_m);
    if (low > job->region_min[a]) job->region_min[a] = (int32_t)fmin(low, job->region_max[a] + 1);
    if (high < job->region_max[a]) job->region_max[a] = (int32_t)fmax(high, job->region_min[a] - 1);
    if (job->region_min[a] > job->region_max[a])
      return np_fail(job->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "cloud: the region's axis %d runs from %g to %g m, must meet a voxel of the cloud's box", a,
                     desc->region_min_m[a], desc->region_max_m[a]);
    const int32_t begin = (int32_t)floor((double)job->region_min[a] / NP_LEAF_EDGE);
    job->leaf_count[a] = (int32_t)floor((double)job->region_max[a] / NP_LEAF_EDGE) - begin + 1;
    job->leaf_begin[a] = begin;
  }
  return NEPH_OK;
}

/* Leaves along each axis: the field's width, and from the base, lower by the curve of the planet at the far corner, to
 * the top. */
static neph_result find_extent(const neph_cloud_desc *cloud, bake_job *job) {
  double leaf_m = cloud->voxel_m * NP_LEAF_EDGE, far2 = 0, product = 1;
  for (int a = 0; a < 2; a++) {
    double voxels = fmax(1.0, round(cloud->extent_m[a] / cloud->voxel_m)), leaves = ceil(voxels / NP_LEAF_EDGE);
    double far = fabs(cloud->center_m[a]) + 0.5 * cloud->extent_m[a];
    product *= leaves;
    far2 += far * far;
    if (product > (double)BOX_LEAVES_MAX) break;
    job->voxels[a] = (int32_t)voxels;
    job->leaf_count[a] = (int32_t)leaves;
  }
  double radius = job->planet_radius_m + cloud->base_altitude_m;
  double drop = far2 < radius * radius ? far2 / (radius + sqrt(radius * radius - far2)) : radius;
  double rain_m = cloud->precipitation * fmax(cloud->base_altitude_m, 0);
  double low = floor(-(drop + rain_m) / leaf_m), high = ceil(cloud->thickness_m / leaf_m);
  product *= high - low;
  if (product > (double)BOX_LEAVES_MAX)
    return np_fail(job->context, NEPH_ERROR_LIMIT,
                   "cloud: extent_m %g × %g and thickness_m %g at voxel_m %g is a box of more than %llu leaves of 8³ "
                   "voxels: enlarge voxel_m or lessen extent_m",
                   cloud->extent_m[0], cloud->extent_m[1], cloud->thickness_m, cloud->voxel_m,
                   (unsigned long long)BOX_LEAVES_MAX);
  job->leaf_begin[2] = (int32_t)low;
  job->leaf_count[2] = (int32_t)(high - low);
  return NEPH_OK;
}

static np_affine find_transform(const bake_job *job) {
  const neph_cloud_desc *cloud = &job->model->desc;
  np_affine transform = np_affine_identity();
  for (int a = 0; a < 3; a++) {
    double origin_m = a == 2 ? cloud->base_altitude_m : cloud->center_m[a];
    transform.m[a][a] = cloud->voxel_m;
    transform.m[a][3] = origin_m + find_offset_m(job, a, 0);
  }
  return transform;
}

static neph_result fill_grid(bake_job *job, np_sparse_grid *grid) {
  job->is_cloudy = np_alloc(job->context, count_box(job), sizeof *job->is_cloudy);
  job->origins = np_alloc(job->context, BATCH_LEAVES, sizeof *job->origins);
  job->leaves = np_alloc(job->context, BATCH_LEAVES, sizeof *job->leaves);
  size_t cloudy_count = 0;
  neph_result result = job->is_cloudy && job->origins && job->leaves ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = find_cloudy(job, &cloudy_count);
  if (!result) result = bake_leaves(job, cloudy_count, grid);
  np_alloc_free(job->context, job->leaves);
  np_alloc_free(job->context, job->origins);
  np_alloc_free(job->context, job->is_cloudy);
  return result;
}

neph_result np_cloud_bake_grid(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               const char *name, np_monitor *monitor, np_sparse_grid *out_grid) {
  np_cloud_model model;
  np_sparse_grid grid;
  bake_job job = {.context = context,
                  .monitor = monitor,
                  .model = &model,
                  .planet_radius_m = desc->planet_radius_m,
                  .prune_per_m = (float)desc->prune_per_m,
                  .memory_max_bytes = desc->memory_max_bytes,
                  .center_m = {cloud->center_m[0], cloud->center_m[1]}};
  neph_result result = find_extent(cloud, &job);
  if (!result) result = clip_extent(cloud, desc, &job);
  if (result) return result;
  np_monitor_set_stage(monitor, "preparing cloud");
  result = np_cloud_model_build(context, cloud, monitor, &model);
  if (result) return result;
  np_monitor_set_stage(monitor, "baking");
  result = np_sparse_grid_init(context, name, &grid);
  if (!result) {
    grid.index_to_world = find_transform(&job);
    result = fill_grid(&job, &grid);
  }
  np_cloud_model_clear(&model);
  if (result) {
    np_sparse_grid_clear(&grid);
    return result;
  }
  *out_grid = grid;
  return NEPH_OK;
}

neph_result np_cloud_bake_desc_read(neph_context *context, const neph_bake_desc *desc, neph_bake_desc *out_desc) {
  static const neph_bake_desc defaults = NEPH_BAKE_DESC_DEFAULT;
  neph_result result = np_desc_read(context, "neph_bake_desc", &defaults, sizeof defaults, desc, out_desc);
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (result) return result;
  if (!(out_desc->planet_radius_m >= 1e3 && out_desc->planet_radius_m <= 1e9))
    return np_fail(context, bad, "cloud: planet_radius_m is %g, must be in [1e3, 1e9]", out_desc->planet_radius_m);
  if (!(out_desc->prune_per_m >= 0 && out_desc->prune_per_m <= 100))
    return np_fail(context, bad, "cloud: prune_per_m is %g, must be in [0, 100]", out_desc->prune_per_m);
  if (out_desc->level_count < 1 || out_desc->level_count > NEPH_BAKE_LEVELS_MAX)
    return np_fail(context, bad, "cloud: level_count is %u, must be in [1, %d]", out_desc->level_count,
                   (int)NEPH_BAKE_LEVELS_MAX);
  for (int a = 0; a < 3 && out_desc->has_region; a++)
    if (!(out_desc->region_max_m[a] > out_desc->region_min_m[a]))
      return np_fail(context, bad, "cloud: region_max_m[%d] is %g, must be above region_min_m[%d], which is %g", a,
                     out_desc->region_max_m[a], a, out_desc->region_min_m[a]);
  return NEPH_OK;
}

neph_result np_cloud_bake_checked(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                  const char *name, np_monitor *monitor, neph_cloud_desc *out_cloud,
                                  neph_bake_desc *out_desc, np_sparse_grid *out_grid) {
  neph_result result = np_cloud_desc_read(context, cloud, out_cloud);
  if (!result) result = np_cloud_bake_desc_read(context, desc, out_desc);
  if (result) return result;
  np_monitor_start(monitor, context, out_desc->progress, out_desc->progress_user);
  return np_cloud_bake_grid(context, out_cloud, out_desc, name, monitor, out_grid);
}

neph_result neph_cloud_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                            neph_volume **out_volume) {
  neph_cloud_desc checked;
  neph_bake_desc bake;
  np_sparse_grid grid;
  np_monitor monitor;
  *out_volume = NULL;
  const unsigned mode = np_float_mode_enter();
  neph_result result = np_cloud_bake_checked(context, cloud, desc, "density", &monitor, &checked, &bake, &grid);
  if (!result) {
    np_monitor_set_stage(&monitor, "building bricks");
    result = np_volume_create_from_grid(context, &grid, bake.precision, &monitor, out_volume);
    np_sparse_grid_clear(&grid);
  }
  np_float_mode_leave(mode);
  return result;
}
