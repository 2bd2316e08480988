/* SPDX-License-Identifier: Apache-2.0 */
#include "render/placement.h"

#include <float.h>

#include "volume/volume_private.h"

/* Largest edge of a voxel, in the unit of the map's range. */
static double largest_voxel_edge(const np_affine *map) {
  double largest = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    const np_dvec3 edge = np_dvec3_make(map->m[0][axis], map->m[1][axis], map->m[2][axis]);
    largest = fmax(largest, np_dvec3_length(edge));
  }
  return largest;
}

static np_affine make_turn(np_axis_up up, double rotation_rad, double scale) {
  const double c = cos(rotation_rad) * scale, s = sin(rotation_rad) * scale;
  const np_affine turn = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, scale, 0}}};
  const np_affine y_to_z = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
  return up == NP_UP_Y ? np_affine_compose(&turn, &y_to_z) : turn;
}

void np_placement_find_bounds(const np_affine *index_to_world, const neph_volume *volume, np_dvec3 *out_min,
                              np_dvec3 *out_max) {
  *out_min = np_dvec3_make(DBL_MAX, DBL_MAX, DBL_MAX);
  *out_max = np_dvec3_make(-DBL_MAX, -DBL_MAX, -DBL_MAX);
  for (int corner = 0; corner < 8; corner++) {
    const np_dvec3 index = np_dvec3_make(corner & 1 ? volume->active_max[0] : volume->active_min[0],
                                         corner & 2 ? volume->active_max[1] : volume->active_min[1],
                                         corner & 4 ? volume->active_max[2] : volume->active_min[2]);
    const np_dvec3 p = np_affine_point(index_to_world, index);
    *out_min = np_dvec3_make(fmin(out_min->x, p.x), fmin(out_min->y, p.y), fmin(out_min->z, p.z));
    *out_max = np_dvec3_make(fmax(out_max->x, p.x), fmax(out_max->y, p.y), fmax(out_max->z, p.z));
  }
}

static void bound_active(np_placement *placement, const neph_volume *volume) {
  np_placement_find_bounds(&placement->index_to_world, volume, &placement->bounds_min, &placement->bounds_max);
}

/* Puts the centre of the bottom face of the bounds at `position_m`. */
static void move_to(np_placement *placement, const neph_volume *volume, const double position_m[3]) {
  bound_active(placement, volume);
  placement->index_to_world.m[0][3] += position_m[0] - 0.5 * (placement->bounds_min.x + placement->bounds_max.x);
  placement->index_to_world.m[1][3] += position_m[1] - 0.5 * (placement->bounds_min.y + placement->bounds_max.y);
  placement->index_to_world.m[2][3] += position_m[2] - placement->bounds_min.z;
}

static neph_result set_extinction(const np_scene_cloud *cloud, const neph_volume *reference, np_monitor *monitor,
                                  np_placement *placement) {
  double extinction = cloud->density_value, column = 0.0;
  neph_result result = np_volume_get_column_max(reference, &placement->index_to_world, monitor, &column);
  if (result) return result;
  switch (cloud->density_unit) {
  case NP_DENSITY_EXTINCTION:
    break;
  case NP_DENSITY_MEAN_FREE_PATH:
    extinction = 1.0 / cloud->density_value;
    break;
  case NP_DENSITY_LIQUID_WATER:
    extinction = 1.5e-6 / cloud->density_value;
    break; /* 1.5·LWC[g/m³]/r_eff[µm] */
  case NP_DENSITY_OPTICAL_DEPTH:
    if (!(column > 0.0))
      return np_fail(reference->context, NEPH_ERROR_BAD_SCENE,
                     "cloud %s: optical_depth is %g, but its grid holds no value above 0", cloud->name, extinction);
    extinction /= column;
    break;
  }
  placement->view.extinction_per_value = (float)extinction;
  const double densest = extinction * (double)reference->value_max;
  np_log(reference->context, NEPH_LOG_INFO,
         "cloud %s: extinction %.4g 1/m at its densest, mean free path %.4g m, optical depth %.4g", cloud->name,
         densest, 1.0 / densest, extinction * column);
  return NEPH_OK;
}

neph_result np_placement_make(const np_scene_cloud *cloud, const neph_volume *volume, const neph_volume *reference,
                              np_monitor *monitor, np_placement *out_placement) {
  double scale = cloud->scale;
  if (cloud->voxel_m > 0.0) scale *= cloud->voxel_m / largest_voxel_edge(&volume->index_to_world);
  const np_affine turn = make_turn(cloud->up, cloud->rotation_rad, scale);
  *out_placement = (np_placement){.index_to_world = np_affine_compose(&turn, &volume->index_to_world)};
  if (cloud->has_position) move_to(out_placement, volume, cloud->position_m);
  bound_active(out_placement, volume);
  np_view_volume *view = &out_placement->view;
  view->bricks = &volume->bricks;
  view->phase = cloud->phase;
  view->bottom_m = out_placement->bounds_min.z;
  view->top_m = out_placement->bounds_max.z;
  for (int b = 0; b < NP_BAND_COUNT; b++) view->albedo.band[b] = (float)cloud->albedo[b];
  if (!np_affine_invert(&out_placement->index_to_world, &view->world_to_index))
    return np_fail(volume->context, NEPH_ERROR_BAD_SCENE, "cloud %s: its transform cannot be inverted", cloud->name);
  return set_extinction(cloud, reference, monitor, out_placement);
}
