/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in memory: volumes with one voxel size or with levels of detail, and the model itself without a grid. */
#include "cloud/bake_volume.h"

#include "cloud/bake_desc.h"
#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/bake_lod.h"
#include "cloud/cloud_build.h"
#include "cloud/cloud_desc.h"
#include "cloud/repeat.h"
#include "core/given.h"
#include "volume/volume_levels.h"
#include "volume/volume_private.h"
#include "volume/volume_tint.h"

/* Whether the region of a level contains a leaf, given by its number along each axis. */
static bool has_cell(const void *user, const int32_t leaf[3]) {
  const int32_t origin[3] = {NP_LEAF_EDGE * leaf[0], NP_LEAF_EDGE * leaf[1], NP_LEAF_EDGE * leaf[2]};
  return np_bake_owns_leaf(user, origin);
}

/* Makes the volume of a bake, or of one of its levels. */
static neph_result make_level(np_bake *level, neph_volume **out_volume) {
  const double count = level->lod.count, begin = level->lod.level / count, end = (level->lod.level + 1) / count;
  np_sparse_grid grid;
  np_monitor_set_part(level->monitor, np_monitor_whole, fmax(begin, 0.05), begin + 0.85 * (end - begin));
  neph_result result = np_bake_make_grid(level, "density", &grid);
  if (result) return result;
  if (level->lod.count > 1) grid.region = (np_cell_region){has_cell, level};
  np_monitor_set_part(level->monitor, np_monitor_whole, begin + 0.85 * (end - begin), end);
  grid.is_consumed = true;
  result = np_volume_create_from_grid(level->context, &grid, level->desc.precision, level->monitor, out_volume);
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result add_level(const np_bake *bake, unsigned number, neph_volume *whole) {
  np_bake level;
  neph_volume *volume = NULL;
  neph_result result = np_bake_get_level(bake, number, &level);
  if (!result && np_bake_count_box(&level) > 0) result = make_level(&level, &volume);
  if (volume) np_volume_add_level(whole, volume);
  return result;
}

neph_result np_bake_make_volume(np_bake *bake, neph_volume **out_volume) {
  neph_volume *whole = NULL;
  neph_result result = make_level(bake, &whole);
  if (result || bake->lod.count == 1) return *out_volume = whole, result;
  result = np_tint_create_levels(bake->context, NP_PARTS_OF_CELLS, &whole->tint);
  for (unsigned k = 1; k < bake->lod.count && !result; k++) result = add_level(bake, k, whole);
  if (result)
    neph_volume_release(whole);
  else
    *out_volume = whole;
  return result;
}

static neph_result bake_volume(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                               np_bake_use use, neph_volume **out_volume) {
  np_bake bake;
  np_monitor monitor;
  *out_volume = NULL;
  const unsigned mode = np_float_mode_enter();
  neph_result result = np_bake_start_checked(context, cloud, desc, use, &monitor, &bake);
  if (!result) {
    bake.desc.error = NULL;
    result = np_bake_make_volume(&bake, out_volume);
    np_bake_end(&bake);
  }
  np_float_mode_leave(mode);
  return result;
}

neph_result neph_cloud_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                            neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume)) return NEPH_ERROR_INVALID_ARGUMENT;
  return bake_volume(context, cloud, desc, NP_BAKE_FOR_BRICKS, out_volume);
}

neph_result np_cloud_bake_sketch(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                 neph_volume **out_volume) {
  return bake_volume(context, cloud, desc, NP_BAKE_FOR_SKETCH, out_volume);
}

/* ---- The model itself ---- */

typedef struct eval_job {
  const np_bake *bake;
  const double *positions_m;
  size_t count;
  float *out_extinction_per_m;
} eval_job;

static neph_result eval_blocks(void *user, size_t begin, size_t end, unsigned thread) {
  const eval_job *job = user;
  const neph_cloud_desc *cloud = &job->bake->model.desc;
  np_bake_points points;
  (void)thread;
  for (size_t block = begin; block < end; block++) {
    const size_t first = block * NP_CLOUD_BLOCK;
    points.count = 0;
    for (size_t i = first; i < job->count && i < first + NP_CLOUD_BLOCK; i++) {
      const double *p = job->positions_m + 3 * i;
      const double offset_m[3] = {np_repeat_fold(cloud, p[0] - cloud->center_m[0]),
                                  np_repeat_fold(cloud, p[1] - cloud->center_m[1]), p[2] - cloud->base_altitude_m};
      np_bake_add_point(job->bake, offset_m, &points);
    }
    np_bake_eval(&job->bake->model, &points, job->out_extinction_per_m + first);
  }
  return NEPH_OK;
}

neph_result neph_cloud_eval(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m, size_t count,
                            const double *positions_m, float *out_extinction_per_m) {
  if (NP_LACKS(context, positions_m, out_extinction_per_m)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_bake bake = {.context = context};
  np_monitor monitor;
  neph_cloud_desc checked;
  neph_result result = np_cloud_desc_read(context, cloud, &checked);
  if (!result) result = np_bake_check_radius(context, planet_radius_m);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, NULL, NULL);
  bake.desc.planet_radius_m = planet_radius_m;
  result = np_cloud_model_build(context, &checked, planet_radius_m, &monitor, &bake.model);
  if (!result) {
    eval_job job = {&bake, positions_m, count, out_extinction_per_m};
    result = np_parallel_for(context, &monitor, (count + NP_CLOUD_BLOCK - 1) / NP_CLOUD_BLOCK, 1, eval_blocks, &job);
    np_bake_end(&bake);
  }
  np_float_mode_leave(mode);
  return result;
}
