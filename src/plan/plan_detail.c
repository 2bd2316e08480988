/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan_detail.h"

#include <math.h>
#include <string.h>

#include "cloud/bake_desc.h"
#include "cloud/bake_field.h"
#include "cloud/cloud_kinds.h"
#include "scene/cloud_places.h"

/* A camera among the clouds, or on the ground, is as far from them as this share of their extent. The edges of snow
 * beside dark ground show where heights are missing from twice as far. */
static const double near_share = 1.0 / 16.0, terrain_near_share = 1.0 / 8.0, snow_near_share = 1.0 / 16.0;

/* Voxels across the least extent of a cloud that are left of it, however small it is in the picture. */
static const double voxels_min = 24.0;

enum { RIDGES_MIN = 64 };

static double get_pixel_rad(const np_request *request, const neph_scene *scene) {
  const np_request detail = np_request_get_detail(request, scene);
  return np_scene_camera_get_pixel_rad(&scene->reach.narrowest, detail.desc.width, detail.desc.height);
}

/* Distance between two boxes. */
static double compute_gap(const double near[3], const double far[3], np_dvec3 low, np_dvec3 high) {
  const np_dvec3 outside = {fmax(fmax(low.x - far[0], near[0] - high.x), 0.0),
                            fmax(fmax(low.y - far[1], near[1] - high.y), 0.0),
                            fmax(fmax(low.z - far[2], near[2] - high.z), 0.0)};
  return np_dvec3_length(outside);
}

/* Distance of a box from the nearest place of the camera in any frame. */
static double compute_nearest(const neph_scene *scene, np_dvec3 low, np_dvec3 high) {
  if (scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) return np_scene_camera_get_target_m(&scene->reach.narrowest);
  return compute_gap(scene->reach.camera_min_m, scene->reach.camera_max_m, low, high);
}

/* Shortest distance of a box from the camera in any frame; for parallel rays the distance of look_at. */
static double compute_distance(const neph_scene *scene, np_dvec3 low, np_dvec3 high) {
  return fmax(compute_nearest(scene, low, high), near_share * np_dvec3_length(np_dvec3_subtract(high, low)));
}

/* The largest power of √2 that is no more than a number, and no less than 1. */
static double round_factor(double factor) { return exp2(0.5 * floor(2.0 * log2(fmax(factor, 1.0)) + 1e-9)); }

/* Distance of a cloud, or of its nearest copy. */
static double compute_cloud_distance(const neph_scene *scene, const np_scene_cloud *cloud,
                                     const neph_cloud_desc *bake) {
  const double *at = cloud->position_m, scale = np_scene_cloud_get_scale(cloud);
  const double half[2] = {0.5 * scale * bake->extent_m[0], 0.5 * scale * bake->extent_m[1]};
  double nearest = HUGE_VAL;
  for (unsigned i = 0; i < cloud->place_count; i++) {
    np_dvec3 own_low, own_high, low, high;
    np_cloud_places_get_box(cloud, bake, scale, &own_low, &own_high);
    np_cloud_place_move_box(&cloud->place[i], own_low, own_high, &low, &high);
    nearest = fmin(nearest, compute_distance(scene, low, high) / cloud->place[i].scale);
  }
  if (cloud->place_count > 0) return nearest;
  const np_dvec3 middle = cloud->has_position
                              ? np_dvec3_make(at[0], at[1], at[2])
                              : np_dvec3_make(bake->center_m[0], bake->center_m[1], bake->base_altitude_m);
  const np_dvec3 low = {middle.x - half[0], middle.y - half[1], middle.z};
  const np_dvec3 high = {middle.x + half[0], middle.y + half[1], middle.z + scale * bake->thickness_m};
  return cloud->level_count > 1 ? compute_nearest(scene, low, high) : compute_distance(scene, low, high);
}

static double compute_factor(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud,
                             const neph_cloud_desc *bake) {
  const double detail_px = scene->render.detail_px;
  if (!(detail_px > 0.0) || !cloud->is_baked || cloud->voxel_m > 0.0) return 1.0;
  const double wanted_m = detail_px * get_pixel_rad(request, scene) * compute_cloud_distance(scene, cloud, bake);
  const double least_m = fmin(fmin(bake->extent_m[0], bake->extent_m[1]), bake->thickness_m) / voxels_min;
  return round_factor(fmin(wanted_m / np_scene_cloud_get_scale(cloud), least_m) / bake->voxel_m);
}

neph_cloud_desc np_plan_get_bake(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  neph_cloud_desc bake = np_scene_cloud_get_frame(cloud, request->desc.frame);
  bake.voxel_m *= compute_factor(request, scene, cloud, &bake);
  return bake;
}

/* ---- Detail finer than voxels ---- */

/* Pixels of a voxel at which detail has all of its strength. */
static const double full_pixels = 2.0 * NP_DETAIL_PIXELS;

/* Width in pixels of a voxel at a box's nearest point, as seen by the frame's camera. */
static double count_voxel_pixels(const np_request *request, const neph_scene *scene, double voxel_m, np_dvec3 low,
                                 np_dvec3 high) {
  const np_scene_camera *camera = &scene->camera;
  const np_request detail = np_request_get_detail(request, scene);
  const double pixel_rad = np_scene_camera_get_pixel_rad(camera, detail.desc.width, detail.desc.height);
  const double distance = camera->kind == NEPH_CAMERA_ORTHOGRAPHIC
                              ? np_scene_camera_get_target_m(camera)
                              : compute_gap(camera->position_m, camera->position_m, low, high);
  return voxel_m / (pixel_rad * fmax(distance, voxel_m));
}

/* Whether the billows of a kind of cloud continue below the voxel size. Sheets, fog, fibres and trails have no billows
 * at their edges. */
static bool has_billows(neph_cloud_model model) {
  return model == NEPH_CLOUD_MODEL_THERMALS || model == NEPH_CLOUD_MODEL_CELLS || model == NEPH_CLOUD_MODEL_HERO ||
         model == NEPH_CLOUD_MODEL_DECK;
}

static bool has_auto_detail(const neph_scene *scene, const np_scene_cloud *cloud) {
  if (scene->render.quality < NP_QUALITY_FINAL) return false;
  if (cloud->is_baked && !has_billows(cloud->bake.model)) return false;
  const bool is_default = cloud->detail.kind == NP_DETAIL_BAKES && cloud->is_baked;
  return cloud->detail.kind == NP_DETAIL_AUTO || (is_default && cloud->interpolation == NEPH_INTERPOLATION_LINEAR);
}

np_scene_detail np_plan_get_fine_detail(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud,
                                        double voxel_m, np_dvec3 low, np_dvec3 high) {
  np_scene_detail detail = cloud->detail;
  if (detail.kind == NP_DETAIL_GIVEN) return detail;
  const double pixels = has_auto_detail(scene, cloud) ? count_voxel_pixels(request, scene, voxel_m, low, high) : 0.0;
  detail.strength *= fmin(fmax((pixels - NP_DETAIL_PIXELS) / (full_pixels - NP_DETAIL_PIXELS), 0.0), 1.0);
  return detail;
}

bool np_plan_has_fine_detail(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  if (cloud->detail.kind == NP_DETAIL_GIVEN) return cloud->detail.strength > 0.0;
  if (!cloud->is_baked || !has_auto_detail(scene, cloud)) return false;
  const neph_cloud_desc bake = np_plan_get_bake(request, scene, cloud);
  const double voxel_m = bake.voxel_m * np_scene_cloud_get_scale(cloud);
  const double pixel_rad = get_pixel_rad(request, scene);
  return voxel_m > NP_DETAIL_PIXELS * pixel_rad * compute_cloud_distance(scene, cloud, &bake);
}

/* ---- Bakes ---- */

/* Sets the viewers. With parallel rays, scale does not depend on the camera's position. */
static void set_viewers(const neph_scene *scene, const np_scene_cloud *cloud, double pixel_rad, neph_bake_desc *desc) {
  if (cloud->level_count < 2 || scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) return;
  desc->lod_count = cloud->level_count;
  desc->lod_angle_rad = fmin(fmax(cloud->level_px, scene->render.detail_px) * pixel_rad, 1.0);
  memcpy(desc->lod_viewer_min_m, scene->reach.camera_min_m, sizeof desc->lod_viewer_min_m);
  memcpy(desc->lod_viewer_max_m, scene->reach.camera_max_m, sizeof desc->lod_viewer_max_m);
}

neph_bake_desc np_plan_get_bake_desc(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = scene->atmosphere.planet_radius_m;
  desc.precision = cloud->precision;
  if (!(cloud->bake.repeat_m > 0.0)) set_viewers(scene, cloud, get_pixel_rad(request, scene), &desc);
  return desc;
}

unsigned np_plan_count_copy_levels(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  const neph_cloud_desc bake = np_plan_get_bake(request, scene, cloud);
  if (!cloud->is_baked || !(bake.repeat_m > 0.0)) return 1;
  set_viewers(scene, cloud, get_pixel_rad(request, scene), &desc);
  const unsigned count = np_bake_count_levels(&bake, &desc);
  return count < NP_COPY_LEVELS_MAX ? count : NP_COPY_LEVELS_MAX;
}

np_lod_viewers np_plan_get_viewers(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  np_lod_viewers viewers;
  set_viewers(scene, cloud, get_pixel_rad(request, scene), &desc);
  memcpy(viewers.min_m, desc.lod_viewer_min_m, sizeof viewers.min_m);
  memcpy(viewers.max_m, desc.lod_viewer_max_m, sizeof viewers.max_m);
  viewers.angle_rad = desc.lod_angle_rad;
  return viewers;
}

void np_plan_describe_file_bake(const neph_scene *scene, const np_scene_cloud *cloud, neph_bake_desc *desc) {
  const np_scene_camera *camera = &scene->reach.narrowest;
  desc->planet_radius_m = scene->atmosphere.planet_radius_m;
  if (cloud->bake.repeat_m > 0.0) return; /* copies are chosen among, not cells */
  set_viewers(scene, cloud,
              np_scene_camera_get_pixel_rad(camera, scene->camera.resolution[0], scene->camera.resolution[1]), desc);
}

/* Voxels in a column of a field, by its distance from the viewers on the map. */
static double compute_column_voxel(const neph_bake_desc *desc, double voxel_m, double x_m, double y_m) {
  const double *low = desc->lod_viewer_min_m, *high = desc->lod_viewer_max_m;
  const double away_m =
      hypot(fmax(fmax(low[0] - x_m, x_m - high[0]), 0.0), fmax(fmax(low[1] - y_m, y_m - high[1]), 0.0));
  for (unsigned k = 1; k < desc->lod_count && 2.0 * voxel_m <= away_m * desc->lod_angle_rad; k++) voxel_m *= 2.0;
  return voxel_m;
}

np_bake_voxels np_plan_count_bake_voxels(const np_request *request, const neph_scene *scene,
                                         const np_scene_cloud *cloud) {
  enum { COLUMNS = 64 };
  const neph_cloud_desc bake = np_plan_get_bake(request, scene, cloud);
  neph_bake_desc desc = np_plan_get_bake_desc(request, scene, cloud);
  desc.lod_count = np_bake_count_levels(&bake, &desc);
  const double column_m3 = bake.extent_m[0] * bake.extent_m[1] * bake.thickness_m / (COLUMNS * COLUMNS);
  const bool has_billows = np_cloud_kind_get(bake.model)->has_thermals;
  np_bake_voxels count = {.box = 0.0};
  for (int n = 0; n < COLUMNS * COLUMNS; n++) {
    const double x_m = bake.center_m[0] + bake.extent_m[0] * ((n % COLUMNS + 0.5) / COLUMNS - 0.5);
    const double y_m = bake.center_m[1] + bake.extent_m[1] * ((n / COLUMNS + 0.5) / COLUMNS - 0.5);
    const double voxel_m = compute_column_voxel(&desc, bake.voxel_m, x_m, y_m);
    const double voxels = column_m3 / (voxel_m * voxel_m * voxel_m);
    count.box += voxels;
    if (has_billows) count.along_billows += voxels * fmin(voxel_m / bake.billow_m, 1.0);
  }
  return count;
}

neph_result np_plan_check_boxes(const np_request *request, const neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    if (!cloud->is_baked) continue;
    const neph_cloud_desc bake = np_plan_get_bake(request, scene, cloud);
    const neph_bake_desc desc = np_plan_get_bake_desc(request, scene, cloud);
    result = np_bake_check_box(scene->context, &bake, &desc);
  }
  return result;
}

bool np_plan_is_coarsened(const np_request *request, const neph_scene *scene, const np_scene_cloud *cloud) {
  return compute_factor(request, scene, cloud, &cloud->bake) > 1.0;
}

neph_ridges_desc np_plan_get_ridges(const np_request *request, const neph_scene *scene) {
  neph_ridges_desc ridges = scene->terrain.ridges;
  const double detail_px = scene->render.detail_px, width_m = scene->terrain.desc.width_m;
  const np_dvec3 high = {0.5 * width_m, 0.5 * width_m, ridges.relief_m}, low = {-high.x, -high.y, 0.0};
  const double share = scene->terrain.desc.has_snow ? snow_near_share : terrain_near_share;
  const double distance = fmax(compute_distance(scene, low, high), share * width_m);
  const double wanted_m = detail_px * get_pixel_rad(request, scene) * distance;
  unsigned steps = ridges.sample_count - 1;
  while (steps / 2 >= RIDGES_MIN && 2.0 * width_m <= steps * wanted_m) steps /= 2;
  ridges.sample_count = steps + 1;
  return ridges;
}

double np_plan_get_light_detail(const neph_scene *scene) {
  bool has_places = false;
  for (unsigned i = 0; i < scene->cloud_count; i++) has_places = has_places || scene->clouds[i].place_count > 0;
  return fmax(scene->render.light_detail_px, has_places ? 1.0 : 0.0);
}

double np_plan_get_light_edge(const np_request *request, const neph_scene *scene, np_dvec3 low, np_dvec3 high) {
  const double detail_px = np_plan_get_light_detail(scene);
  if (!(detail_px > 0.0) || !(low.x <= high.x)) return 0.0;
  return detail_px * get_pixel_rad(request, scene) * compute_distance(scene, low, high);
}
