/* SPDX-License-Identifier: Apache-2.0 */
/* Slope of the thermals, without their billows: it distinguishes tops from flanks.
 *
 * Vertical components of normals of the first level of balls, at nodes of a lattice in the frame of the air; linear
 * between nodes. Nodes are a quarter of a billow apart: they are few compared with the points, so that their search
 * costs little. */
#include "cloud/thermal_slope.h"

#include <math.h>

#include "cloud/repeat.h"
#include "core/math.h"

static const float node_step = 0.25f;       /* in largest billows */
static const float node_voxels_min = 2.25f; /* a run of points, 9 voxels or 5 node_steps wide, is within 6 steps */

/* Nodes around a run of points. */
typedef struct slope_nodes {
  float step_m, origin_m[3]; /* step and origin of the lattice */
  int32_t first[3], count[3];
  float normal_z[NP_BALL_BLOCK];
} slope_nodes;

static float compute_step_m(const np_cloud_model *model) {
  const float step_m = np_maxf(node_step * model->thermals.billow_m, node_voxels_min * (float)model->desc.voxel_m);
  return np_repeat_fit(&model->desc, step_m);
}

static float scale_position(const slope_nodes *nodes, int axis, float at_m) {
  return (at_m - nodes->origin_m[axis]) / nodes->step_m;
}

static void place_nodes(const np_cloud_model *model, const np_ball_points *points, slope_nodes *nodes) {
  const float *at_m[3] = {points->x_m, points->y_m, points->z_m};
  nodes->step_m = compute_step_m(model);
  for (int a = 0; a < 3; a++) {
    nodes->origin_m[a] = a < 2 ? model->drift_m[a] : 0.0f;
    float low_m = at_m[a][0], high_m = at_m[a][0];
    for (size_t i = 1; i < points->count; i++) {
      low_m = np_minf(low_m, at_m[a][i]);
      high_m = np_maxf(high_m, at_m[a][i]);
    }
    nodes->first[a] = (int32_t)floorf(scale_position(nodes, a, low_m));
    nodes->count[a] = (int32_t)floorf(scale_position(nodes, a, high_m)) - nodes->first[a] + 2;
  }
}

/* False: no thermal is near. */
static bool search_nodes(const np_cloud_model *model, slope_nodes *nodes) {
  float x[NP_BALL_BLOCK], y[NP_BALL_BLOCK], z[NP_BALL_BLOCK];
  float distance_m[NP_BALL_BLOCK], age[NP_BALL_BLOCK], radius_m[NP_BALL_BLOCK], normal[2][NP_BALL_BLOCK];
  const np_thermal_noises *t = &model->thermals;
  const float search_m = t->reach_max_m + t->warp_max_m + t->billow_m;
  np_ball_heap stacks = model->balls;
  size_t count = 0;
  for (int32_t i = 0; i < nodes->count[0]; i++)
    for (int32_t j = 0; j < nodes->count[1]; j++)
      for (int32_t k = 0; k < nodes->count[2]; k++, count++) {
        x[count] = nodes->origin_m[0] + (float)(nodes->first[0] + i) * nodes->step_m;
        y[count] = nodes->origin_m[1] + (float)(nodes->first[1] + j) * nodes->step_m;
        z[count] = nodes->origin_m[2] + (float)(nodes->first[2] + k) * nodes->step_m;
      }
  const np_ball_points points = {count, x, y, z};
  const np_ball_surface surface = {distance_m, age, radius_m, {normal[0], normal[1], nodes->normal_z}};
  if (stacks.level_count > 1) stacks.level_count = 1;
  if (!np_ball_heap_search(&stacks, &points, search_m, &surface)) return false;
  for (size_t n = 0; n < count; n++) nodes->normal_z[n] = distance_m[n] < search_m ? nodes->normal_z[n] : 0.0f;
  return true;
}

static float interpolate(const slope_nodes *nodes, const float at_m[3]) {
  float share[3], rows[4];
  size_t cell = 0;
  for (int a = 0; a < 3; a++) {
    const float scaled = scale_position(nodes, a, at_m[a]), low = floorf(scaled);
    share[a] = scaled - low;
    cell = cell * (size_t)nodes->count[a] + (size_t)((int32_t)low - nodes->first[a]);
  }
  for (size_t r = 0; r < 4; r++) {
    const float *row =
        &nodes->normal_z[cell + ((r >> 1) * (size_t)nodes->count[1] + (r & 1)) * (size_t)nodes->count[2]];
    rows[r] = np_mixf(row[0], row[1], share[2]);
  }
  return np_mixf(np_mixf(rows[0], rows[1], share[1]), np_mixf(rows[2], rows[3], share[1]), share[0]);
}

void np_thermals_eval_slope(const np_cloud_model *model, const np_ball_points *points, float *out_normal_z) {
  slope_nodes nodes;
  place_nodes(model, points, &nodes);
  const bool is_any = search_nodes(model, &nodes);
  for (size_t i = 0; i < points->count; i++) {
    const float at_m[3] = {points->x_m[i], points->y_m[i], points->z_m[i]};
    out_normal_z[i] = is_any ? interpolate(&nodes, at_m) : 0.0f;
  }
}
