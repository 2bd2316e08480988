/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in memory: what may be asked of a bake, volumes, and the model itself without a grid. */
#include "cloud/bake_private.h"
#include "cloud/repeat.h"
#include "core/given.h"
#include "volume/volume_private.h"

static neph_result check_region(neph_context *context, const neph_bake_desc *desc) {
  for (int a = 0; a < 3 && desc->has_region; a++)
    if (!(desc->region_max_m[a] > desc->region_min_m[a]))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "cloud: region_max_m[%d] is %g, must be above region_min_m[%d], which is %g", a,
                     desc->region_max_m[a], a, desc->region_min_m[a]);
  return NEPH_OK;
}

static neph_result check_radius(neph_context *context, double planet_radius_m) {
  if (planet_radius_m >= 1e3 && planet_radius_m <= 1e9) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "cloud: planet_radius_m is %g, must be in [1e3, 1e9]",
                 planet_radius_m);
}

/* Coarser grids of a level would stand where another level is. */
static neph_result check_levels(neph_context *context, const neph_bake_desc *desc) {
  if (desc->lod_count == 1 || desc->level_count == 1) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "cloud: level_count is %u, must be 1 where lod_count is %u, above 1 (bake.levels)", desc->level_count,
                 desc->lod_count);
}

neph_result np_cloud_bake_desc_read(neph_context *context, const neph_bake_desc *desc, neph_bake_desc *out_desc) {
  static const neph_bake_desc defaults = NEPH_BAKE_DESC_DEFAULT;
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(context, "neph_bake_desc", &defaults, sizeof defaults, desc, out_desc);
  if (!result && out_desc->error)
    result = np_desc_check_size(context, "neph_bake_error", out_desc->error, sizeof *out_desc->error);
  if (!result) result = check_radius(context, out_desc->planet_radius_m);
  if (result) return result;
  if (!(out_desc->prune_per_m >= 0 && out_desc->prune_per_m <= 100))
    return np_fail(context, bad, "cloud: prune_per_m is %g, must be in [0, 100]", out_desc->prune_per_m);
  if (out_desc->level_count < 1 || out_desc->level_count > NEPH_BAKE_LEVELS_MAX)
    return np_fail(context, bad, "cloud: level_count is %u, must be in [1, %d]", out_desc->level_count,
                   (int)NEPH_BAKE_LEVELS_MAX);
  if (out_desc->lod_count < 1 || out_desc->lod_count > NEPH_BAKE_LODS_MAX)
    return np_fail(context, bad, "cloud: lod_count is %u, must be in [1, %d]", out_desc->lod_count,
                   (int)NEPH_BAKE_LODS_MAX);
  if (!(out_desc->lod_angle_rad > 0 && out_desc->lod_angle_rad <= 1))
    return np_fail(context, bad, "cloud: lod_angle_rad is %g, must be in (0, 1]", out_desc->lod_angle_rad);
  for (int a = 0; a < 3; a++)
    if (!(out_desc->lod_viewer_min_m[a] <= out_desc->lod_viewer_max_m[a]))
      return np_fail(context, bad,
                     "cloud: lod_viewer_max_m[%d] is %g, must be at least lod_viewer_min_m[%d], which is %g", a,
                     out_desc->lod_viewer_max_m[a], a, out_desc->lod_viewer_min_m[a]);
  result = check_levels(context, out_desc);
  return result ? result : check_region(context, out_desc);
}

neph_result neph_cloud_bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                            neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_bake bake;
  np_monitor monitor;
  *out_volume = NULL;
  const unsigned mode = np_float_mode_enter();
  neph_result result = np_bake_start_checked(context, cloud, desc, NP_BAKE_FOR_BRICKS, &monitor, &bake);
  if (!result) {
    bake.desc.error = NULL;
    result = np_bake_make_volume(&bake, out_volume);
    np_bake_end(&bake);
  }
  np_float_mode_leave(mode);
  return result;
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
  if (!result) result = check_radius(context, planet_radius_m);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, NULL, NULL);
  bake.desc.planet_radius_m = planet_radius_m;
  result = np_cloud_model_build(context, &checked, &monitor, &bake.model);
  if (!result) {
    eval_job job = {&bake, positions_m, count, out_extinction_per_m};
    result = np_parallel_for(context, &monitor, (count + NP_CLOUD_BLOCK - 1) / NP_CLOUD_BLOCK, 1, eval_blocks, &job);
    np_bake_end(&bake);
  }
  np_float_mode_leave(mode);
  return result;
}
