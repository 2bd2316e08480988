/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/placement.h"

#include <float.h>

#include "core/text.h"
#include "volume/volume_private.h"
#include "volume/volume_tint.h"

double np_placement_get_voxel_edge(const np_affine *map) {
  double largest = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    const np_dvec3 edge = np_dvec3_make(map->m[0][axis], map->m[1][axis], map->m[2][axis]);
    largest = fmax(largest, np_dvec3_length(edge));
  }
  return largest;
}

/* Rotation about x, y or z, counter-clockwise as seen from the axis's positive end. */
static np_affine make_rotation(int axis, double angle_rad) {
  const double c = cos(angle_rad), s = sin(angle_rad);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  np_affine out = {{{0}}};
  out.m[axis][axis] = 1.0;
  out.m[u][u] = out.m[v][v] = c;
  out.m[u][v] = -s;
  out.m[v][u] = s;
  return out;
}

np_affine np_placement_make_turn(const np_scene_cloud *cloud, double scale) {
  const double *s = cloud->scale;
  const np_affine y_to_z = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
  np_affine turn = {{{s[0] * scale, 0, 0, 0}, {0, s[1] * scale, 0, 0}, {0, 0, s[2] * scale, 0}}};
  if (cloud->up == NP_UP_Y) turn = np_affine_compose(&turn, &y_to_z);
  const double angles[3] = {cloud->tilt_rad[0], cloud->tilt_rad[1], cloud->rotation_rad};
  for (int axis = 0; axis < 3; axis++) {
    const np_affine rotation = make_rotation(axis, angles[axis]);
    if (angles[axis] != 0.0) turn = np_affine_compose(&rotation, &turn);
  }
  return turn;
}

void np_placement_compute_bounds(const np_affine *index_to_world, const neph_volume *volume, np_dvec3 *out_min,
                                 np_dvec3 *out_max) {
  *out_min = np_dvec3_make(DBL_MAX, DBL_MAX, DBL_MAX);
  *out_max = np_dvec3_make(-DBL_MAX, -DBL_MAX, -DBL_MAX);
  for (int corner = 0; corner < 8; corner++) {
    const np_dvec3 index = np_dvec3_make(corner & 1 ? volume->active_max[0] : volume->active_min[0],
                                         corner & 2 ? volume->active_max[1] : volume->active_min[1],
                                         corner & 4 ? volume->active_max[2] : volume->active_min[2]);
    const np_dvec3 p = np_affine_point(index_to_world, index);
    *out_min = np_dvec3_min(*out_min, p);
    *out_max = np_dvec3_max(*out_max, p);
  }
}

static bool is_pivot_of_box(const np_scene_cloud *cloud) {
  return cloud->pivot == NP_PIVOT_BASE || cloud->pivot == NP_PIVOT_CENTER;
}

static np_dvec3 get_pivot(const np_scene_cloud *cloud, const np_affine *file_to_world, np_dvec3 low, np_dvec3 high) {
  const double *point = cloud->pivot_point;
  if (cloud->pivot == NP_PIVOT_ORIGIN) return np_affine_point(file_to_world, np_dvec3_make(0, 0, 0));
  if (cloud->pivot == NP_PIVOT_POINT)
    return np_affine_point(file_to_world, np_dvec3_make(point[0], point[1], point[2]));
  const double z = cloud->pivot == NP_PIVOT_BASE ? low.z : 0.5 * (low.z + high.z);
  return np_dvec3_make(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), z);
}

void np_placement_move_box(const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high, np_affine *file_to_world) {
  if (!cloud->has_position) return;
  const np_dvec3 pivot = get_pivot(cloud, file_to_world, low, high);
  file_to_world->m[0][3] += cloud->position_m[0] - pivot.x;
  file_to_world->m[1][3] += cloud->position_m[1] - pivot.y;
  file_to_world->m[2][3] += cloud->position_m[2] - pivot.z;
}

/* Moves a cloud's pivot to its position. */
static void move_to(const np_scene_cloud *cloud, const neph_volume *volume, np_affine *file_to_world) {
  np_dvec3 low = {0, 0, 0}, high = {0, 0, 0};
  if (is_pivot_of_box(cloud)) {
    const np_affine index_to_world = np_affine_compose(file_to_world, &volume->index_to_world);
    np_placement_compute_bounds(&index_to_world, volume, &low, &high);
  }
  np_placement_move_box(cloud, low, high, file_to_world);
}

/* Warns if one value dominates the densest column, so that scaling by it would make all other values negligible. */
static void check_column(const np_scene_cloud *cloud, const neph_volume *volume, const np_affine *index_to_world,
                         double column) {
  static const double share_max = 0.9;
  const double largest = (double)volume->value_max * np_placement_get_voxel_edge(index_to_world);
  const double height = (double)volume->active_max[2] - volume->active_min[2];
  if (height < 8.0 || largest < share_max * column) return;
  np_log(
      volume->context, NEPH_LOG_WARNING,
      "cloud %s: one voxel of value %.4g holds %.3g %% of the densest column, which optical_depth scales: all others "
      "become thin; nephos check shows where it is, clouds[].ramp cuts it",
      cloud->name, (double)volume->value_max, 100.0 * fmin(largest / column, 1.0));
}

static void log_extinction(const np_scene_cloud *cloud, const neph_volume *volume, double extinction, double column) {
  const double densest = extinction * (double)volume->value_max;
  np_log(volume->context, NEPH_LOG_INFO,
         "cloud %s: extinction %.4g 1/m at its densest, mean free path %.4g m, optical depth %.4g", cloud->name,
         densest, 1.0 / densest, extinction * column);
}

double np_placement_get_extinction(const np_scene_cloud *cloud, double of_file) {
  switch (cloud->density_unit) {
  case NP_DENSITY_MEAN_FREE_PATH:
    return 1.0 / cloud->density_value;
  case NP_DENSITY_LIQUID_WATER:
    return 1.5e-6 / cloud->density_value; /* 1.5·LWC[g/m³]/r_eff[µm] */
  case NP_DENSITY_OF_FILE:
    return of_file;
  case NP_DENSITY_EXTINCTION:
  case NP_DENSITY_OPTICAL_DEPTH:
    break;
  }
  return cloud->density_value;
}

/* Extinction of a value of 1. The densest column is measured where the cloud's unit or the log needs it. */
static neph_result compute_extinction(const np_scene_cloud *cloud, const neph_volume *volume,
                                      const np_affine *index_to_world, np_monitor *monitor, float *out_per_value) {
  const bool has_levels = np_volume_has_parts(volume, NP_PARTS_OF_CELLS); /* one column would be in several */
  const bool is_told = !has_levels && np_log_is_wanted(volume->context, NEPH_LOG_INFO);
  const bool is_scaled = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
  double extinction = np_placement_get_extinction(cloud, volume->extinction_per_value), column = 0.0;
  neph_result result = NEPH_OK;
  if (is_told || is_scaled) result = np_volume_get_column_max(volume, index_to_world, monitor, &column);
  if (result) return result;
  if (is_scaled && !(column > 0.0))
    return np_fail(volume->context, NEPH_ERROR_BAD_SCENE,
                   "cloud %s: optical_depth is %g, but its grid holds no value above 0", cloud->name, extinction);
  if (is_scaled) {
    check_column(cloud, volume, index_to_world, column);
    extinction /= column;
  }
  *out_per_value = (float)extinction;
  if (is_told) log_extinction(cloud, volume, extinction, column);
  return NEPH_OK;
}

/* Scale by which the file's voxels get the length of the scene's key, before any resampling. */
static double compute_voxel_scale(const np_scene_cloud *cloud, const neph_volume *volume) {
  if (!(cloud->voxel_m > 0.0)) return 1.0;
  const double edge = np_placement_get_voxel_edge(&volume->index_to_world);
  return cloud->voxel_m / (volume->is_halved ? 0.5 * edge : edge);
}

bool np_placement_needs_reference(const np_scene_cloud *cloud) {
  return (cloud->has_position && is_pivot_of_box(cloud)) || cloud->voxel_m > 0.0 ||
         cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
}

neph_result np_placement_anchor(const np_scene_cloud *cloud, const neph_volume *reference, np_monitor *monitor,
                                np_anchor *out_anchor) {
  const double scale = compute_voxel_scale(cloud, reference);
  *out_anchor = (np_anchor){.file_to_world = np_placement_make_turn(cloud, scale)};
  np_affine *file_to_world = &out_anchor->file_to_world;
  if (cloud->has_position) move_to(cloud, reference, file_to_world);
  if (cloud->density_unit != NP_DENSITY_OPTICAL_DEPTH) return NEPH_OK;
  const np_affine index_to_world = np_affine_compose(file_to_world, &reference->index_to_world);
  return compute_extinction(cloud, reference, &index_to_world, monitor, &out_anchor->extinction_per_value);
}

neph_result np_placement_make(const np_scene_cloud *cloud, const np_anchor *anchor, const neph_volume *volume,
                              np_monitor *monitor, np_placement *out_placement) {
  const np_affine index_to_world = np_affine_compose(&anchor->file_to_world, &volume->index_to_world);
  *out_placement = (np_placement){.index_to_world = index_to_world};
  np_placement_compute_bounds(&index_to_world, volume, &out_placement->bounds_min, &out_placement->bounds_max);
  np_instance *world = &out_placement->world;
  world->bricks = &volume->bricks;
  world->phase = cloud->phase;
  world->bottom_m = out_placement->bounds_min.z;
  world->top_m = out_placement->bounds_max.z;
  world->extinction_per_value = anchor->extinction_per_value;
  for (int b = 0; b < NP_BAND_COUNT; b++) world->albedo.band[b] = (float)cloud->albedo[b];
  if (!np_affine_invert(&index_to_world, &world->world_to_index))
    return np_fail(volume->context, NEPH_ERROR_BAD_SCENE, "cloud %s: its transform cannot be inverted", cloud->name);
  if (cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH) return NEPH_OK;
  return compute_extinction(cloud, volume, &index_to_world, monitor, &world->extinction_per_value);
}

/* ---- Clouds that cannot be meant: out of the picture, or of a size that no cloud has ---- */

static const double smallest_m = 10.0, largest_m = 1e6;

typedef struct cloud_box {
  const np_scene_cloud *cloud;
  const np_placement_view *view;
  np_dvec3 low, high;
} cloud_box;

static double get_size(const cloud_box *box) {
  const np_dvec3 size = np_dvec3_subtract(box->high, box->low);
  return fmax(fmax(size.x, size.y), size.z);
}

static bool is_small(const cloud_box *box, np_placement_fault *out) {
  const double size_m = get_size(box);
  if (!(size_m < smallest_m)) return false;
  np_print(out->cause, sizeof out->cause, "is %.3g m across, less than %g m", size_m, smallest_m);
  return true;
}

static bool is_large(const cloud_box *box, np_placement_fault *out) {
  const double size_m = get_size(box);
  if (!(size_m > largest_m)) return false;
  np_print(out->cause, sizeof out->cause, "is %.4g km across, more than %g km", 1e-3 * size_m, 1e-3 * largest_m);
  return true;
}

static bool is_out_of_view(const cloud_box *box, np_placement_fault *out) {
  const np_dvec3 low = box->low, high = box->high;
  if (np_camera_sees_box(box->view->camera, low, high)) return false;
  np_print(out->cause, sizeof out->cause,
           "lies wholly outside the view, from (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g) km", 1e-3 * low.x, 1e-3 * low.y,
           1e-3 * low.z, 1e-3 * high.x, 1e-3 * high.y, 1e-3 * high.z);
  return true;
}

/* Depths of the nearest corner of a box, and of the farthest. */
static void compute_depths(const cloud_box *box, double *nearest_m, double *farthest_m) {
  double depth_m, film[2];
  *nearest_m = HUGE_VAL;
  *farthest_m = -HUGE_VAL;
  for (int corner = 0; corner < 8; corner++) {
    (void)np_camera_project(box->view->camera,
                            np_dvec3_make(corner & 1 ? box->high.x : box->low.x, corner & 2 ? box->high.y : box->low.y,
                                          corner & 4 ? box->high.z : box->low.z),
                            film, &depth_m);
    *nearest_m = fmin(*nearest_m, depth_m);
    *farthest_m = fmax(*farthest_m, depth_m);
  }
}

static bool is_before_near(const cloud_box *box, np_placement_fault *out) {
  const double near_m = box->view->camera->near_m;
  double nearest_m, farthest_m;
  compute_depths(box, &nearest_m, &farthest_m);
  if (!(farthest_m > 0.0) || farthest_m >= near_m) return false;
  np_print(out->cause, sizeof out->cause, "ends %.4g m before the camera, whose near plane, %.4g m away, cuts it off",
           farthest_m, near_m);
  return true;
}

static bool is_beyond_far(const cloud_box *box, np_placement_fault *out) {
  const double far_m = box->view->camera->far_m;
  double nearest_m, farthest_m;
  compute_depths(box, &nearest_m, &farthest_m);
  if (!(nearest_m > far_m)) return false;
  np_print(out->cause, sizeof out->cause, "begins %.4g m before the camera, whose far plane, %.4g m away, cuts it off",
           nearest_m, far_m);
  return true;
}

static np_dvec3 get_corner(const cloud_box *box, int corner) {
  return np_dvec3_make(corner & 1 ? box->high.x : box->low.x, corner & 2 ? box->high.y : box->low.y,
                       corner & 4 ? box->high.z : box->low.z);
}

/* Whether the projected box is narrower and lower than a pixel. */
static bool is_below_pixel(const cloud_box *box, np_placement_fault *out) {
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL}, depth_m, film[2];
  if (!np_camera_sees_box(box->view->camera, box->low, box->high)) return false;
  for (int corner = 0; corner < 8; corner++) {
    if (!np_camera_project(box->view->camera, get_corner(box, corner), film, &depth_m)) return false;
    for (int a = 0; a < 2; a++) {
      low[a] = fmin(low[a], film[a]);
      high[a] = fmax(high[a], film[a]);
    }
  }
  const double size_px = fmax(high[0] - low[0], high[1] - low[1]);
  if (!(size_px < 1.0)) return false;
  np_print(out->cause, sizeof out->cause, "subtends %.2g of a pixel, %.4g km before the camera", size_px,
           1e-3 * depth_m);
  return true;
}

static double get_gap(double low, double high, double other_low, double other_high) {
  return fmax(fmax(low - other_high, other_low - high), 0.0);
}

/* Further than their larger size and beyond a horizon, where no cloud of a picture of that terrain is. A terrain
 * reaches as far as its border is continued. */
static bool is_far_from_terrain(const cloud_box *box, np_placement_fault *out) {
  static const double horizon_m = 1e5;
  np_dvec3 low, high;
  if (!box->view->terrain) return false;
  np_terrain_get_bounds(box->view->terrain, &low, &high);
  const double gap_m =
      hypot(get_gap(box->low.x, box->high.x, low.x, high.x), get_gap(box->low.y, box->high.y, low.y, high.y));
  const double terrain_m = fmax(high.x - low.x, high.y - low.y);
  if (!(gap_m > fmax(horizon_m, fmax(terrain_m, get_size(box))))) return false;
  np_print(out->cause, sizeof out->cause,
           "lies %.4g km from the terrain, which is %.4g km across: are its coordinates in another system?",
           1e-3 * gap_m, 1e-3 * terrain_m);
  return true;
}

/* Depth of a place below the sphere, or the terrain over it. */
static double get_depth_below_ground(const np_placement_view *view, np_dvec3 p) {
  static const double far_m = 2e5;
  const double radius = view->planet_radius_m, altitude = np_altitude(p, radius);
  np_terrain_hit hit;
  if (!view->terrain || !np_terrain_covers(view->terrain, p.x, p.y)) return -altitude;
  if (np_terrain_intersect(view->terrain, p, np_vec3_make(0.0f, 0.0f, 1.0f), far_m, &hit)) return (double)hit.distance;
  return -1.0;
}

/* The top is below the ground at each of 25 places. */
static bool is_below_ground(const cloud_box *box, np_placement_fault *out) {
  enum { PLACES = 5 };
  double least_m = HUGE_VAL;
  if (!(box->view->planet_radius_m > 0.0)) return false;
  for (int i = 0; i < PLACES * PLACES; i++) {
    const double u = (double)(i % PLACES) / (PLACES - 1), v = (double)(i / PLACES) / (PLACES - 1);
    const np_dvec3 p = np_dvec3_make(box->low.x + u * (box->high.x - box->low.x),
                                     box->low.y + v * (box->high.y - box->low.y), box->high.z);
    least_m = fmin(least_m, get_depth_below_ground(box->view, p));
    if (!(least_m > 0.0)) return false;
  }
  np_print(out->cause, sizeof out->cause, "lies wholly below the ground, its top %.4g m or more", least_m);
  return true;
}

unsigned np_placement_list_faults(const np_scene_cloud *cloud, const np_placement_view *view, np_dvec3 low,
                                  np_dvec3 high, np_placement_fault out_faults[NP_PLACEMENT_FAULTS_MAX]) {
  static const struct {
    const char *rule;
    bool (*is_broken)(const cloud_box *box, np_placement_fault *out);
    const char *file_keys, *bake_keys;
  } rules[NP_PLACEMENT_FAULTS_MAX] = {
      {"cloud.small", is_small, "clouds[].voxel and scale", "clouds[].bake.extent and scale"},
      {"cloud.large", is_large, "clouds[].voxel and scale", "clouds[].bake.extent and scale"},
      {"cloud.out_of_view", is_out_of_view, "clouds[].position, voxel and up, and camera.look_at",
       "clouds[].bake.center and bake.base, and camera.look_at"},
      {"cloud.before_near", is_before_near, "camera.near, and clouds[].position, voxel and up",
       "camera.near, and clouds[].bake.center and bake.base"},
      {"cloud.beyond_far", is_beyond_far, "camera.far, and clouds[].position, voxel and up",
       "camera.far, and clouds[].bake.center and bake.base"},
      {"cloud.below_pixel", is_below_pixel, "clouds[].position, voxel and scale, and camera.fov",
       "clouds[].bake.center and bake.extent, and camera.fov"},
      {"cloud.far_from_terrain", is_far_from_terrain, "clouds[].position, terrain.crs and place",
       "clouds[].bake.center, and place"},
      {"cloud.below_ground", is_below_ground, "clouds[].position, voxel and up", "clouds[].bake.center and bake.base"}};
  const cloud_box box = {cloud, view, low, high};
  unsigned count = 0;
  if (cloud->repeat != NP_REPEAT_NONE) return 0; /* it is everywhere */
  for (size_t i = 0; i < NP_PLACEMENT_FAULTS_MAX; i++) {
    out_faults[count].rule = rules[i].rule;
    out_faults[count].keys = cloud->is_baked ? rules[i].bake_keys : rules[i].file_keys;
    count += rules[i].is_broken(&box, &out_faults[count]);
  }
  return count;
}

void np_placement_check(neph_context *context, const np_scene_cloud *cloud, const np_placement_view *view, np_dvec3 low,
                        np_dvec3 high) {
  np_placement_fault faults[NP_PLACEMENT_FAULTS_MAX];
  const unsigned count = np_placement_list_faults(cloud, view, low, high, faults);
  for (unsigned i = 0; i < count; i++)
    np_log(context, NEPH_LOG_WARNING, "cloud %s: %s: check %s", cloud->name, faults[i].cause, faults[i].keys);
}
