/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of the sun through the cells, and what each cell takes of them. Compiled once per instruction-set level. */
#include "core/isa.h"
#include "light/first_collision.h"

neph_result NP_KERNEL(np_first_rays_follow)(void *user, size_t begin, size_t end, unsigned thread);

/* Cell of a coordinate along an axis, and where in it that is, from its middle over its width; −1 or the size outside. */
static int32_t locate_along(const np_transport_grid *g, int axis, double x, double *out_offset) {
  x = np_transport_grid_wrap(g, axis, x);
  if (g->even_m[axis] > 0.0) {
    const double cells = (x - g->edge_m[axis][0]) / g->even_m[axis], at = floor(cells);
    *out_offset = cells - at - 0.5;
    return (int32_t)np_clamp(at, -1.0, (double)g->size[axis]);
  }
  const int32_t at = np_transport_grid_locate(g, axis, x), inside = at < 0 ? 0 : at < g->size[axis] ? at : 0;
  *out_offset = (x - np_transport_grid_middle(g, axis, inside)) / np_transport_grid_width(g, axis, inside);
  return at;
}

/* Live cell of a position, and where in it that is. */
static int32_t locate(const np_transport_grid *g, const double p[3], double out_offset[3]) {
  int32_t at[3];
  for (int a = 0; a < 3; a++) {
    at[a] = locate_along(g, a, p[a], &out_offset[a]);
    if (at[a] == g->size[a] && g->is_wrapped[a]) at[a] = 0;
    if (at[a] < 0 || at[a] >= g->size[a]) return NP_TRANSPORT_CELL_NONE;
    out_offset[a] = np_clamp(out_offset[a], -0.5, 0.5);
  }
  return g->live[np_transport_grid_join(g, at)];
}

static double find_exit(const np_transport_grid *g, const double p[3], const double d[3]) {
  double exit = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (g->is_wrapped[a] || fabs(d[a]) < 1e-12) continue;
    const double plane = g->edge_m[a][d[a] > 0.0 ? g->size[a] : 0];
    exit = fmin(exit, (plane - p[a]) / d[a]);
  }
  return exit;
}

/* A step from `t` on; where cells differ, no longer than half of one. */
static double find_step(const np_first_rays *r, const double start[3], double t) {
  const np_transport_grid *g = r->grid;
  double step = r->step_m;
  for (int a = 0; a < 3; a++) {
    if (g->even_m[a] > 0.0 || fabs(r->direction[a]) < 1e-9) continue;
    const int32_t at = np_transport_grid_locate(g, a, start[a] + t * r->direction[a]);
    const int32_t inside = at < 0 ? 0 : at < g->size[a] ? at : g->size[a] - 1;
    step = fmin(step, 0.5 * np_transport_grid_width(g, a, inside) / fabs(r->direction[a]));
  }
  return step;
}

static void count_loss(const np_first_medium *m, const np_transport_grid *g, int32_t live, const double offset[3],
                       double lost) {
  np_first_loss *l = &m->losses[live];
  (void)__atomic_fetch_add(&l->sum, (int64_t)(lost + 0.5), __ATOMIC_RELAXED);
  for (int a = 0; a < 3; a++)
    if (g->size[a] > 1) (void)__atomic_fetch_add(&l->moment[a], (int64_t)(offset[a] * lost), __ATOMIC_RELAXED);
}

/* Of a step that is a share of the longest: what the second medium has left beyond the first in its middle. */
static void count_surplus(const np_first_rays *r, int32_t live, double share, double beyond, double weight) {
  np_first_surplus *s = &r->surpluses[live];
  if (beyond > 0.0) (void)__atomic_fetch_add(&s->sum, (int64_t)(beyond * share), __ATOMIC_RELAXED);
  (void)__atomic_fetch_add(&s->length, (int64_t)(weight * 0x1p32 * share), __ATOMIC_RELAXED);
}

/* What the media take from a step around `p`; `power` is what is left of the ray in each. */
static void cross_step(const np_first_rays *r, const double p[3], double h, double weight,
                       double power[NP_FIRST_MEDIA]) {
  double depth[NP_FIRST_MEDIA] = {0.0}, middle[NP_FIRST_MEDIA] = {power[0], power[1]}, offset[3];
  const np_dvec3 position = np_dvec3_make(p[0], p[1], p[2]);
  for (unsigned v = 0; v < r->view->volume_count; v++) {
    const double own = h * (double)np_view_extinction(&r->view->volumes[v], position);
    for (unsigned m = 0; m < r->media_count; m++) depth[m] += own * (double)r->media[m].scale[v];
  }
  const bool is_lost = depth[0] > 0.0;
  if (!is_lost && !r->surpluses) return;
  const int32_t live = locate(r->grid, p, offset);
  if (live < 0) return;
  for (unsigned m = 0; m < r->media_count && is_lost; m++) {
    const double lost = -expm1(-depth[m]) * power[m];
    count_loss(&r->media[m], r->grid, live, offset, lost);
    middle[m] -= 0.5 * lost;
    power[m] -= lost;
  }
  if (r->surpluses) count_surplus(r, live, h / r->step_m, middle[1] - middle[0], weight);
}

/* `weight` is the ray's area over that of a cell's share in the units. */
static void follow_ray(const np_first_rays *r, const double start[3], double weight) {
  const double exit = find_exit(r->grid, start, r->direction);
  double power[NP_FIRST_MEDIA] = {weight * 0x1p32, r->media_count > 1 ? weight * 0x1p32 : 0.0};
  double t = 0.0;
  while (t < exit && fmax(power[0], power[1]) > weight * 0x1p14) {
    const double h = fmin(find_step(r, start, t), exit - t), middle = t + 0.5 * h;
    t += h;
    cross_step(r,
               (const double[3]){start[0] + middle * r->direction[0], start[1] + middle * r->direction[1],
                                 start[2] + middle * r->direction[2]},
               h, weight, power);
  }
}

static double fraction(double x) { return x - floor(x); }

/* Row after row, so that what a ray looks at is at hand from the last; each row is turned against the one before. */
static void start_ray(const np_first_rays *r, int axis, size_t number) {
  const np_transport_grid *g = r->grid;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const size_t row = number / r->columns, column = number % r->columns;
  const double across = ((double)column + fraction(0.5 + 0.6180339887498949 * (double)row)) / (double)r->columns;
  double start[3];
  start[axis] = g->edge_m[axis][r->direction[axis] < 0.0 ? g->size[axis] : 0];
  start[b] = g->edge_m[b][0] + across * np_transport_grid_length(g, b);
  start[c] = g->edge_m[c][0] + ((double)row + 0.5) / (double)r->rows * np_transport_grid_length(g, c);
  const double face_cells = (double)g->size[b] * (double)g->size[c];
  /* Irradiance on the face times area, over the mean area of a cell's face. */
  follow_ray(r, start, fabs(r->direction[axis]) * face_cells / ((double)r->rows * (double)r->columns));
}

/* Some of those that start on the present face. */
neph_result NP_KERNEL(np_first_rays_follow)(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_first_rays *r = user;
  for (size_t number = begin; number < end; number++) {
    if (np_monitor_is_cancelled(r->monitor)) return NEPH_ERROR_CANCELLED;
    start_ray(r, r->face_axis, number);
  }
  return NEPH_OK;
}
