/* SPDX-License-Identifier: Apache-2.0 */
/* The densest column of a volume: what the scene's `optical_depth` scales.
 *
 * World-vertical lines are parallel in index space. They start from the samples of the layer in the middle of the
 * active box, across the axis that is closest to vertical; where the lines are oblique the layer is widened by the
 * shear, so that they cover the whole shadow of the box. Between two crossings of integer planes the trilinear field
 * along a line is a cubic, which Gauss-Legendre quadrature with two points integrates exactly.
 */
#include "volume/volume_private.h"

#include <float.h>

#include "core/alloc.h"

typedef struct volume_columns {
  const np_bricks *bricks;
  int axis, across[2]; /* the index axis along the lines, and the other two */
  double step[3];      /* direction of a line, in index units for one metre upwards */
  double middle;       /* index of the layer along `axis` */
  int32_t low[2];      /* first line of the layer along `across` */
  int32_t size[2];
  double *thread_max; /* the largest integral each thread has found */
} volume_columns;

static double get_component(np_dvec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* The next crossing of an integer plane behind `t`, at most `t_end`. */
static double compute_crossing(const np_brick_walk *walk, double t, double t_end) {
  double crossing = t_end;
  for (int a = 0; a < 3; a++) {
    if (walk->inverse[a] == 0.0) continue;
    double at = walk->origin[a] + t * walk->direction[a], whole = np_brick_floor(at);
    double forward = walk->inverse[a] > 0.0 ? 1.0 : -1.0;
    double plane = forward > 0.0 ? whole + 1.0 : whole < at ? whole : whole - 1.0;
    double t_plane = (plane - walk->origin[a]) * walk->inverse[a];
    if (!(t_plane > t)) t_plane = (plane + forward - walk->origin[a]) * walk->inverse[a]; /* rounded onto this plane */
    if (t_plane > t && t_plane < crossing) crossing = t_plane;
  }
  return crossing;
}

static double sample_span(const np_brick_walk *walk, const np_brick_span *span, double t) {
  return (double)np_brick_sample(walk->bricks, span->brick, np_brick_walk_local(walk, span, t));
}

static double integrate_span(const np_brick_walk *walk, const np_brick_span *span) {
  static const double gauss = 0.57735026918962576451; /* 1/√3 */
  if (span->brick == NP_BRICK_NONE) return (double)span->range.min * (span->t_end - span->t_begin);
  double sum = 0.0;
  for (double t = span->t_begin; t < span->t_end;) {
    double next = compute_crossing(walk, t, span->t_end), center = 0.5 * (t + next), half = 0.5 * (next - t);
    sum += half * (sample_span(walk, span, center - gauss * half) + sample_span(walk, span, center + gauss * half));
    t = next;
  }
  return sum;
}

static double integrate_column(const volume_columns *c, int32_t u, int32_t v) {
  double origin[3];
  origin[c->axis] = c->middle;
  origin[c->across[0]] = c->low[0] + u;
  origin[c->across[1]] = c->low[1] + v;
  np_brick_walk walk;
  np_brick_span span;
  double sum = 0.0;
  np_brick_walk_start(&walk, c->bricks, np_dvec3_make(origin[0], origin[1], origin[2]),
                      np_dvec3_make(c->step[0], c->step[1], c->step[2]), -DBL_MAX, DBL_MAX);
  while (np_brick_walk_next(&walk, &span)) sum += integrate_span(&walk, &span);
  return sum;
}

static neph_result integrate_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const volume_columns *c = user;
  for (size_t u = begin; u < end; u++)
    for (int32_t v = 0; v < c->size[1]; v++) {
      double integral = integrate_column(c, (int32_t)u, v);
      if (integral > c->thread_max[thread]) c->thread_max[thread] = integral;
    }
  return NEPH_OK;
}

/* Along each axis across the lines: the box, and as far beyond as a line moves between the layer and the box's ends. */
static void set_layer(volume_columns *c, const neph_volume *volume) {
  double low = volume->active_min[c->axis], high = volume->active_max[c->axis];
  c->middle = np_brick_floor(0.5 * (low + high));
  for (int n = 0; n < 2; n++) {
    int a = c->across[n];
    double slope = fabs(c->step[a] / c->step[c->axis]);
    bool is_periodic = a < 2 && c->bricks->is_periodic[a];
    int32_t beyond = is_periodic ? 0 : (int32_t)ceil(slope * (fmax(high - c->middle, c->middle - low) + 1.0) - 1e-9);
    c->low[n] = volume->active_min[a] - beyond;
    c->size[n] = volume->active_max[a] - volume->active_min[a] + 1 + 2 * beyond;
  }
}

static neph_result set_lines(volume_columns *c, const neph_volume *volume, const np_affine *index_to_world) {
  np_affine world_to_index;
  if (!np_affine_invert(index_to_world, &world_to_index))
    return np_fail(volume->context, NEPH_ERROR_INVALID_ARGUMENT, "grid '%s': the placed transform cannot be inverted",
                   volume->name);
  np_dvec3 step = np_affine_vector(&world_to_index, np_dvec3_make(0.0, 0.0, 1.0));
  c->axis = 0;
  for (int a = 0; a < 3; a++) {
    c->step[a] = get_component(step, a);
    if (fabs(c->step[a]) > fabs(c->step[c->axis])) c->axis = a;
  }
  /* The rounding error of a right angle would make lines along the samples oblique. */
  for (int a = 0; a < 3; a++)
    if (fabs(c->step[a]) < 1e-12 * fabs(c->step[c->axis])) c->step[a] = 0.0;
  c->across[0] = c->axis == 0 ? 1 : 0;
  c->across[1] = c->axis == 2 ? 1 : 2;
  return NEPH_OK;
}

neph_result np_volume_get_column_max(const neph_volume *volume, const np_affine *index_to_world, np_monitor *monitor,
                                     double *out_value_m) {
  neph_context *context = volume->context;
  volume_columns c = {.bricks = &volume->bricks};
  *out_value_m = 0.0;
  neph_result result = set_lines(&c, volume, index_to_world);
  if (result) return result;
  set_layer(&c, volume);
  c.thread_max = np_alloc(context, context->thread_count, sizeof *c.thread_max);
  if (!c.thread_max) return NEPH_ERROR_OUT_OF_MEMORY;
  np_monitor_set_stage(monitor, "measuring columns");
  result = np_parallel_for(context, monitor, (size_t)c.size[0], 1, integrate_rows, &c);
  for (unsigned i = 0; i < context->thread_count && !result; i++) *out_value_m = fmax(*out_value_m, c.thread_max[i]);
  np_alloc_free(context, c.thread_max);
  return result;
}
