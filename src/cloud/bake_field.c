/* SPDX-License-Identifier: Apache-2.0 */
/* Positions of the voxels of a bake: samples are at the centres of voxels, leaves of 8³ voxels start at the index
 * origin, and a region clips the voxels. */
#include "cloud/bake_field.h"

#include "cloud/bake_desc.h"
#include "cloud/bake_lod.h"
#include "cloud/bake_loss.h"
#include "cloud/cloud_build.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_desc.h"
#include "cloud/cloud_name.h"
#include "cloud/repeat.h"

#define BOX_LEAVES_MAX (UINT64_C(1) << 27) /* leaves of the whole field: one byte each during the search for cloud */

void np_bake_add_point(const np_bake *bake, const double offset_m[3], np_bake_points *points) {
  const size_t n = points->count++;
  points->x_m[n] = (float)offset_m[0];
  points->y_m[n] = (float)offset_m[1];
  points->height_m[n] = (float)np_bake_compute_height_m(bake, offset_m);
}

void np_bake_eval(const np_cloud_model *model, const np_bake_points *points, float *out_extinction_per_m) {
  const np_cloud_points view = {points->count, points->x_m, points->y_m, points->height_m};
  np_cloud_model_eval(model, &view, out_extinction_per_m);
}

np_affine np_bake_compute_transform(const np_bake *bake) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  np_affine transform = np_affine_identity();
  for (int a = 0; a < 3; a++) {
    const double origin_m = a == 2 ? cloud->base_altitude_m : cloud->center_m[a];
    transform.m[a][a] = bake->voxel_m;
    transform.m[a][3] = origin_m + np_bake_compute_offset_m(bake, a, 0);
  }
  return transform;
}

size_t np_bake_count_box(const np_bake *bake) {
  return (size_t)bake->leaf_count[0] * (size_t)bake->leaf_count[1] * (size_t)bake->leaf_count[2];
}

/* ---- The box ---- */

static neph_result refuse_box(const np_bake *bake) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  return np_fail(bake->context, NEPH_ERROR_LIMIT,
                 "%s: an extent of %g × %g m and a thickness of %g m with a voxel of %g m are a box of more than %llu "
                 "leaves of 8³ voxels: enlarge voxel or reduce extent",
                 np_cloud_desc_name(cloud), cloud->extent_m[0], cloud->extent_m[1], cloud->thickness_m, cloud->voxel_m,
                 (unsigned long long)BOX_LEAVES_MAX);
}

/* Drop of the planet's surface at the far corner of the field. */
static double compute_drop_m(const np_bake *bake) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  double far2 = 0;
  for (int a = 0; a < 2; a++) {
    const double far = fabs(cloud->center_m[a]) + 0.5 * cloud->extent_m[a];
    far2 += far * far;
  }
  const double radius = bake->desc.planet_radius_m + cloud->base_altitude_m;
  return far2 < radius * radius ? far2 / (radius + sqrt(radius * radius - far2)) : radius;
}

void np_bake_compute_field(const np_bake *bake, double out_low_m[3], double out_high_m[3]) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  const double rain_m = cloud->precipitation * fmax(cloud->base_altitude_m, 0);
  for (int a = 0; a < 2; a++) {
    out_low_m[a] = -0.5 * cloud->extent_m[a];
    out_high_m[a] = 0.5 * cloud->extent_m[a];
  }
  out_low_m[2] = -(compute_drop_m(bake) + rain_m);
  out_high_m[2] = cloud->thickness_m;
}

/* Number of leaves along each axis that covers the field. */
static neph_result compute_extent(np_bake *bake) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  const double leaf_m = bake->voxel_m * NP_LEAF_EDGE, finest_m = np_bake_get_finest_m(bake);
  double product = 1;
  for (int a = 0; a < 2; a++) {
    const double voxels = fmax(1.0, round(cloud->extent_m[a] / finest_m));
    const double leaves = ceil(ldexp(voxels / NP_LEAF_EDGE, -(int)bake->lod.level));
    product *= leaves;
    if (product > (double)BOX_LEAVES_MAX) return refuse_box(bake);
    bake->shift[a] = ldexp(-0.5 * (voxels - 1), -(int)bake->lod.level);
    bake->leaf_count[a] = (int32_t)leaves;
    bake->leaf_begin[a] = 0;
  }
  bake->shift[2] = ldexp(0.5, -(int)bake->lod.level);
  double low_m[3], high_m[3];
  np_bake_compute_field(bake, low_m, high_m);
  const double low = floor(low_m[2] / leaf_m), high = ceil(high_m[2] / leaf_m);
  product *= high - low;
  if (product > (double)BOX_LEAVES_MAX) return refuse_box(bake);
  bake->leaf_begin[2] = (int32_t)low;
  bake->leaf_count[2] = (int32_t)(high - low);
  return NEPH_OK;
}

/* Clips one axis to the region. */
static void clip_axis(np_bake *bake, int a) {
  const neph_cloud_desc *cloud = &bake->model.desc;
  const double first_m = (a == 2 ? cloud->base_altitude_m : cloud->center_m[a]) + np_bake_compute_offset_m(bake, a, 0);
  const double low = ceil((bake->desc.region_min_m[a] - first_m) / bake->voxel_m);
  const double high = floor((bake->desc.region_max_m[a] - first_m) / bake->voxel_m);
  if (low > bake->region_min[a]) bake->region_min[a] = (int32_t)fmin(low, bake->region_max[a] + 1);
  if (high < bake->region_max[a]) bake->region_max[a] = (int32_t)fmax(high, bake->region_min[a] - 1);
}

/* Clips the leaves of an axis to the region. It must contain a sample of the finest level; another level without
 * samples in it is empty. */
static neph_result clip_leaves(np_bake *bake, int a) {
  const bool is_empty = bake->region_min[a] > bake->region_max[a];
  const int32_t begin = (int32_t)floor((double)bake->region_min[a] / NP_LEAF_EDGE);
  bake->leaf_count[a] = is_empty ? 0 : (int32_t)floor((double)bake->region_max[a] / NP_LEAF_EDGE) - begin + 1;
  bake->leaf_begin[a] = begin;
  if (!is_empty || bake->lod.level > 0) return NEPH_OK;
  return np_fail(bake->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: the region runs from %g to %g m along %c, must meet a voxel of the cloud's box",
                 np_cloud_desc_name(&bake->model.desc), bake->desc.region_min_m[a], bake->desc.region_max_m[a],
                 "xyz"[a]);
}

/* Clips the box of leaves to the voxels of the region. */
static neph_result clip_extent(np_bake *bake) {
  for (int a = 0; a < 3; a++) {
    bake->region_min[a] = bake->leaf_begin[a] * NP_LEAF_EDGE;
    bake->region_max[a] = (bake->leaf_begin[a] + bake->leaf_count[a]) * NP_LEAF_EDGE - 1;
    if (a < 2 && bake->model.desc.repeat_m > 0) /* begin of the next tile */
      bake->region_max[a] = (int32_t)round(-2 * bake->shift[a]);
    if (bake->desc.has_region) clip_axis(bake, a);
    const neph_result result = clip_leaves(bake, a);
    if (result) return result;
  }
  return NEPH_OK;
}

/* Clips the box to the reach of a level of detail; the result may be empty. */
static void clip_to_level(np_bake *bake) {
  const double leaf_m = bake->voxel_m * NP_LEAF_EDGE, reach_m = np_bake_get_reach_m(bake) + bake->lod.cell_m;
  for (int a = 0; a < 3 && isfinite(reach_m); a++) {
    const double first_m = np_bake_compute_offset_m(bake, a, 0);
    const double low = floor((bake->lod.viewers.min_m[a] - reach_m - first_m) / leaf_m);
    const double high = ceil((bake->lod.viewers.max_m[a] + reach_m - first_m) / leaf_m);
    const double begin = fmax(bake->leaf_begin[a], low), end = fmin(bake->leaf_begin[a] + bake->leaf_count[a], high);
    bake->leaf_begin[a] = (int32_t)fmin(begin, bake->leaf_begin[a] + bake->leaf_count[a]);
    bake->leaf_count[a] = (int32_t)fmax(end - bake->leaf_begin[a], 0);
  }
}

static neph_result set_box(np_bake *bake) {
  neph_result result = compute_extent(bake);
  if (!result) result = clip_extent(bake);
  if (!result && bake->lod.count > 1) clip_to_level(bake);
  return result;
}

/* ---- Start ---- */

/* The finest level of detail; its box is set later. */
static np_bake_lod make_lod(const neph_cloud_desc *cloud, const neph_bake_desc *desc) {
  np_bake_lod lod = {.count = np_bake_count_levels(cloud, desc), .viewers.angle_rad = desc->lod_angle_rad};
  lod.cell_m = ldexp(NP_LEAF_EDGE * cloud->voxel_m, (int)lod.count - 1);
  for (int a = 0; a < 3; a++) {
    const double origin_m = a == 2 ? cloud->base_altitude_m : cloud->center_m[a];
    lod.viewers.min_m[a] = desc->lod_viewer_min_m[a] - origin_m;
    lod.viewers.max_m[a] = desc->lod_viewer_max_m[a] - origin_m;
  }
  return lod;
}

/* Sets the box of the finest level. */
static neph_result lay_out(const neph_cloud_desc *rounded, const neph_bake_desc *desc, np_bake *bake) {
  bake->desc = *desc;
  bake->model.desc = *rounded;
  bake->lod = make_lod(rounded, desc);
  bake->voxel_m = rounded->voxel_m;
  return set_box(bake);
}

neph_result np_bake_check_box(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc) {
  const neph_cloud_desc rounded = np_repeat_round(cloud);
  np_bake bake = {.context = context};
  return lay_out(&rounded, desc, &bake);
}

/* Builds the model. The losses of a sketch are not those of the bake that replaces it. */
static neph_result build_model(np_bake *bake, const neph_cloud_desc *cloud) {
  const double radius_m = bake->desc.planet_radius_m;
  if (bake->use == NP_BAKE_FOR_SKETCH)
    return np_cloud_model_sketch(bake->context, cloud, radius_m, bake->monitor, &bake->model);
  neph_result result = np_cloud_model_build(bake->context, cloud, radius_m, bake->monitor, &bake->model);
  if (result) return result;
  result = np_bake_warn_of_losses(bake->context, &bake->model, bake->monitor);
  if (result) np_bake_end(bake);
  return result;
}

neph_result np_bake_start(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                          np_bake_use use, np_monitor *monitor, np_bake *out_bake) {
  const neph_cloud_desc rounded = np_repeat_round(cloud);
  *out_bake = (np_bake){.context = context, .monitor = monitor, .use = use};
  neph_result result = lay_out(&rounded, desc, out_bake);
  for (int a = 0; a < 3; a++) out_bake->lod.origin_m[a] = np_bake_compute_offset_m(out_bake, a, 0);
  np_monitor_set_part(monitor, np_monitor_whole, 0.0, 0.05);
  np_monitor_set_stage(monitor, "preparing cloud");
  return result ? result : build_model(out_bake, &rounded);
}

neph_result np_bake_get_level(const np_bake *bake, unsigned level, np_bake *out_level) {
  *out_level = *bake;
  out_level->lod.level = level;
  out_level->voxel_m = ldexp(bake->voxel_m, (int)level);
  return set_box(out_level);
}

neph_result np_bake_start_checked(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                  np_bake_use use, np_monitor *monitor, np_bake *out_bake) {
  neph_cloud_desc checked;
  neph_bake_desc bake;
  neph_result result = np_cloud_desc_read(context, cloud, &checked);
  if (!result) result = np_cloud_bake_desc_read(context, desc, &bake);
  if (result) return result;
  np_monitor_start(monitor, context, bake.progress, bake.progress_user);
  return np_bake_start(context, &checked, &bake, use, monitor, out_bake);
}

void np_bake_end(np_bake *bake) { np_cloud_model_clear(&bake->model); }
