/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/bake_desc.h"

#include <math.h>

#include "core/context_private.h"

static neph_result check_region(neph_context *context, const neph_bake_desc *desc) {
  for (int a = 0; a < 3 && desc->has_region; a++)
    if (!(desc->region_max_m[a] > desc->region_min_m[a]))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "cloud: region_max_m[%d] is %g, must be above region_min_m[%d], which is %g", a,
                     desc->region_max_m[a], a, desc->region_min_m[a]);
  return NEPH_OK;
}

neph_result np_bake_check_radius(neph_context *context, double planet_radius_m) {
  if (planet_radius_m >= 1e3 && planet_radius_m <= 1e9) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "cloud: planet_radius_m is %g, must be in [1e3, 1e9]",
                 planet_radius_m);
}

/* Checks the levels. The bake itself must be the finest level: coarser grids of a level would overlap another level. */
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
  if (!result) result = np_bake_check_radius(context, out_desc->planet_radius_m);
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

/* Least number of voxels across the thickness in the coarsest level. Mean optical depths then change by less than 1 %
 * (test_bake_lod); with a quarter as many, thin sheets change by 2 to 11 %. */
static const double thickness_voxels_min = 8;

unsigned np_bake_count_levels(const neph_cloud_desc *cloud, const neph_bake_desc *desc) {
  unsigned count = desc->lod_count;
  while (count > 1 && ldexp(cloud->voxel_m, (int)count - 1) * thickness_voxels_min > cloud->thickness_m) count--;
  return count;
}
