/* SPDX-License-Identifier: Apache-2.0 */
/* First level of a cloud of a given shape. Spheres are balls; a curve is a Catmull-Rom spline of balls, spaced so
 * closely that gaps between them are below a hundredth of their radius. Meshes and height maps are a distance grid
 * below all balls. A shape keeps its position while its billows turn over. */
#include "cloud/shape.h"

#include <math.h>

#include "cloud/ball_rows.h"
#include "cloud/cloud_name.h"
#include "cloud/shape_desc.h"
#include "cloud/shape_mesh.h"
#include "core/alloc.h"
#include "core/math.h"

static const float curve_spacing = 0.2f; /* spacing of balls, in the smaller radius */

enum { BALLS_MAX = 1 << 20 /* balls of a segment */ };

/* ---- Curves ---- */

static np_ball make_ball(const np_cloud_model *model, const neph_cloud_point *p) {
  const neph_cloud_desc *desc = &model->desc;
  return (np_ball){.x_m = (float)p->x_m,
                   .y_m = (float)p->y_m,
                   .z_m = (float)p->z_m,
                   .radius_m = (float)p->radius_m,
                   .age = np_shape_compute_age((float)desc->age, (float)p->z_m, (float)desc->thickness_m)};
}

/* Position by the spline, with doubled end points; the radius is linear. */
static double eval_cubic(double before, double from, double to, double after, double t) {
  const double slope[2] = {0.5 * (to - before), 0.5 * (after - from)}, rise = to - from;
  return from + t * (slope[0] + t * (3 * rise - 2 * slope[0] - slope[1] + t * (slope[0] + slope[1] - 2 * rise)));
}

static neph_cloud_point eval_spline(const neph_cloud_point *points, size_t count, size_t segment, double t) {
  const neph_cloud_point *before = &points[segment ? segment - 1 : 0], *from = &points[segment], *to = from + 1;
  const neph_cloud_point *after = &points[segment + 2 < count ? segment + 2 : count - 1];
  return (neph_cloud_point){eval_cubic(before->x_m, from->x_m, to->x_m, after->x_m, t),
                            eval_cubic(before->y_m, from->y_m, to->y_m, after->y_m, t),
                            eval_cubic(before->z_m, from->z_m, to->z_m, after->z_m, t),
                            from->radius_m + t * (to->radius_m - from->radius_m)};
}

static double compute_length(const neph_cloud_point *points, size_t count, size_t segment) {
  enum { STEPS = 8 };
  double length = 0;
  neph_cloud_point from = points[segment];
  for (int i = 1; i <= STEPS; i++) {
    const neph_cloud_point to = eval_spline(points, count, segment, i / (double)STEPS);
    length += np_dvec3_length(np_dvec3_make(to.x_m - from.x_m, to.y_m - from.y_m, to.z_m - from.z_m));
    from = to;
  }
  return length;
}

static neph_result add_curve(const np_cloud_model *model, const neph_cloud_point *points, size_t count,
                             np_ball_list *list) {
  neph_result result = NEPH_OK;
  for (size_t s = 0; s + 1 < count && !result; s++) {
    const double least_m = fmin(points[s].radius_m, points[s + 1].radius_m);
    const double steps = ceil(compute_length(points, count, s) / ((double)curve_spacing * least_m));
    if (!(steps <= BALLS_MAX))
      return np_fail(model->map.context, NEPH_ERROR_LIMIT,
                     "%s.shape.curves: a segment with a radius of %g m takes %.3g balls, may take %d: enlarge the "
                     "radius or cut the curve",
                     np_cloud_desc_name(&model->desc), least_m, steps, (int)BALLS_MAX);
    for (int i = s ? 1 : 0; i <= (int)steps && !result; i++) {
      const neph_cloud_point at = eval_spline(points, count, s, steps > 0 ? i / steps : 0);
      const np_ball ball = make_ball(model, &at);
      result = np_ball_list_add(model->map.context, list, &ball);
    }
  }
  return result;
}

/* ---- Balls ---- */

/* Adds the balls of a row: spheres in the first row, one curve in each other. */
static neph_result add_row(const void *user, size_t row, np_ball_list *list) {
  const np_cloud_model *model = user;
  const neph_cloud_points *spheres = &model->desc.shape.spheres, *curves = &model->desc.shape.curves;
  neph_result result = NEPH_OK;
  if (row > 0) {
    const size_t first = row > 1 ? curves->ends[row - 2] : 0;
    return add_curve(model, curves->points + first, curves->ends[row - 1] - first, list);
  }
  for (size_t i = 0; i < spheres->count && !result; i++) {
    const np_ball ball = make_ball(model, &spheres->points[i]);
    result = np_ball_list_add(model->map.context, list, &ball);
  }
  return result;
}

neph_result np_shape_add_balls(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m) {
  model->balls.shape = model->shape;
  return np_ball_rows_collect(&model->balls, monitor, 1 + model->desc.shape.curves.curve_count, add_row, model, blend_m,
                              bin_m);
}

/* ---- Bounds ---- */

typedef struct shape_box {
  float low_m[3], high_m[3];
} shape_box;

static void include_ball(const np_ball *ball, shape_box *box) {
  const float at_m[3] = {ball->x_m, ball->y_m, ball->z_m};
  for (int a = 0; a < 3; a++) {
    box->low_m[a] = np_minf(box->low_m[a], at_m[a] - ball->radius_m);
    box->high_m[a] = np_maxf(box->high_m[a], at_m[a] + ball->radius_m);
  }
}

static shape_box measure_balls(const np_cloud_model *model, unsigned first_level) {
  shape_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (unsigned l = first_level; l < model->balls.level_count; l++)
    for (size_t i = 0; i < model->balls.levels[l].count; i++) {
      const np_ball ball = np_ball_level_get(&model->balls.levels[l], i);
      include_ball(&ball, &box);
    }
  return box;
}

/* Adds the grid's content, which is smaller than the grid by a billow. */
static void include_grid(const np_shape_grid *grid, float room_m, shape_box *box) {
  for (int a = 0; a < 3; a++) {
    const float high_m = grid->origin_m[a] + (float)(grid->size[a] - 1) * grid->step_m;
    box->low_m[a] = np_minf(box->low_m[a], grid->origin_m[a] + room_m);
    box->high_m[a] = np_maxf(box->high_m[a], high_m - room_m - grid->step_m);
  }
}

static neph_result check_box(const np_cloud_model *model, const shape_box *box) {
  static const char *const names[] = {"x", "y", "height"};
  const neph_cloud_desc *desc = &model->desc;
  const float margin_m = 1e-3f * (float)desc->thickness_m;
  for (int a = 0; a < 3; a++) {
    const float low_m = a < 2 ? -0.5f * (float)desc->extent_m[a] : -INFINITY;
    const float high_m = a < 2 ? -low_m : (float)desc->thickness_m;
    if (box->low_m[a] >= low_m - margin_m && box->high_m[a] <= high_m + margin_m) continue;
    return np_fail(model->map.context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s.shape reaches from %.4g to %.4g m in %s, must stay %s%.4g m: enlarge %s, or move the shape",
                   np_cloud_desc_name(desc), (double)box->low_m[a], (double)box->high_m[a], names[a],
                   a < 2 ? "within ±" : "below the top, ", (double)high_m, a < 2 ? "extent" : "thickness");
  }
  if (box->high_m[2] > 0) return NEPH_OK;
  return np_fail(model->map.context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s.shape ends %.4g m below the base, where it is cut, must reach above it: move it up",
                 np_cloud_desc_name(desc), (double)-box->high_m[2]);
}

void np_shape_check_billows(const np_cloud_model *model) {
  const shape_box box = measure_balls(model, 1);
  float beyond_m = 0.0f;
  for (int a = 0; a < 2; a++) {
    const float half_m = 0.5f * (float)model->desc.extent_m[a];
    beyond_m = np_maxf(beyond_m, np_maxf(-half_m - box.low_m[a], box.high_m[a] - half_m));
  }
  if (beyond_m > (float)model->desc.voxel_m)
    np_log(model->map.context, NEPH_LOG_WARNING,
           "%s.shape: billows reach %.3g m beyond the field, whose side cuts them off: enlarge extent",
           np_cloud_desc_name(&model->desc), (double)beyond_m);
}

/* ---- Projection ---- */

enum { SHADOW_EDGE = 96, SHADOW_HEIGHTS = 24 };

/* Strength of a column: its largest depth in the shape, 1 for half a billow or more. */
static float compute_strength(const np_cloud_model *model, float x_m, float y_m) {
  float x[SHADOW_HEIGHTS], y[SHADOW_HEIGHTS], z[SHADOW_HEIGHTS], distance_m[SHADOW_HEIGHTS], lowest_m = 0.0f;
  const np_ball_points points = {SHADOW_HEIGHTS, x, y, z};
  const np_ball_surface surface = {.distance_m = distance_m};
  for (int k = 0; k < SHADOW_HEIGHTS; k++) {
    x[k] = x_m;
    y[k] = y_m;
    z[k] = ((float)k + 0.5f) / SHADOW_HEIGHTS * (float)model->desc.thickness_m;
  }
  if (!np_ball_heap_search(&model->balls, &points, 0.0f, &surface)) return 0.0f;
  for (int k = 0; k < SHADOW_HEIGHTS; k++) lowest_m = np_minf(lowest_m, distance_m[k]);
  return np_minf(-lowest_m / (0.5f * model->thermals.billow_m), 1.0f);
}

static neph_result cast_shadow(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_weather_map *map = &model->map;
  const double longest_m = fmax(desc->extent_m[0], desc->extent_m[1]);
  const bool is_wet = desc->precipitation > 0;
  map->step_m = (float)longest_m / (is_wet ? SHADOW_EDGE : 1);
  for (int a = 0; a < 2; a++) {
    map->size[a] = (int32_t)ceil(desc->extent_m[a] / (double)map->step_m) + 1;
    map->origin_m[a] = -0.5f * (float)(map->size[a] - 1) * map->step_m;
  }
  map->values = np_alloc(map->context, (size_t)map->size[0] * (size_t)map->size[1], sizeof *map->values);
  if (!map->values) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int32_t j = 0; j < map->size[1] && is_wet; j++)
    for (int32_t i = 0; i < map->size[0]; i++)
      map->values[(size_t)j * (size_t)map->size[0] + (size_t)i] =
          compute_strength(model, map->origin_m[0] + (float)i * map->step_m, map->origin_m[1] + (float)j * map->step_m);
  map->highest = 1.0f;
  map->coverage = 1.0;
  map->radius_m = model->thermals.billow_m;
  return NEPH_OK;
}

/* ---- Entry points ---- */

static neph_result build_grid(np_cloud_model *model, np_monitor *monitor) {
  const neph_cloud_desc *desc = &model->desc;
  const char *file = desc->shape.mesh_file ? desc->shape.mesh_file : desc->shape.height_map;
  np_mesh_tree tree = {0};
  if (!file) return NEPH_OK;
  model->shape = np_alloc(model->map.context, 1, sizeof *model->shape);
  if (!model->shape) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result =
      desc->shape.mesh_file ? np_shape_load_mesh(model, monitor, &tree) : np_shape_load_heights(model, &tree);
  if (!result) result = np_shape_measure(model, monitor, file, &tree, model->shape);
  np_mesh_tree_clear(&tree);
  model->shape->radius_max_m = model->thermals.billow_m;
  model->shape->age = (float)desc->age;
  model->shape->thickness_m = (float)desc->thickness_m;
  return result;
}

neph_result np_shape_build(np_cloud_model *model, np_monitor *monitor) {
  const float billow_m = model->thermals.billow_m;
  model->map.context = model->context;
  model->depth_scale = 1.0f;
  model->slope_per_m = 1.0f / billow_m;
  neph_result result = build_grid(model, monitor);
  if (!result) result = np_shape_add_balls(model, monitor, 0.1f * billow_m, 0.5f * billow_m);
  if (!result) {
    shape_box box = measure_balls(model, 0);
    if (model->shape) include_grid(model->shape, billow_m, &box);
    result = check_box(model, &box);
  }
  return result ? result : cast_shadow(model);
}
