/* SPDX-License-Identifier: Apache-2.0 */
/* Where sunlight first collides. */
#include "core/alloc.h"
#include "light/transport_grid.h"

/* Parallel rays start on every face that the sun shines on, at low-discrepancy points, each for an equal area. What a
 * step of a ray loses is counted in the cell of its middle, in whole units of 2⁻³²: sums of integers come out the same
 * in any order, whatever thread adds them. */
typedef struct sun_rays {
  const np_scene_view *view;
  const np_scaled_phase *phases;
  unsigned band;
  np_monitor *monitor;
  np_transport_grid *grid;
  uint64_t *units;
  double direction[3]; /* of flight */
  double step_m;       /* the longest */
  int face_axis;
  size_t first[4]; /* ray number at which each face begins */
} sun_rays;

enum { RAYS_PER_CELL_EDGE = 3 };

static size_t count_face_rays(const np_transport_grid *g, int axis, const double direction[3]) {
  if (g->is_wrapped[axis]) return 0;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const double cells = (double)g->size[b] * (double)g->size[c] * fabs(direction[axis]);
  const double least = g->size[b] == 1 || g->size[c] == 1 ? 64.0 : 1.0;
  return fabs(direction[axis]) < 1e-6 ? 0 : (size_t)fmax(ceil(cells * RAYS_PER_CELL_EDGE * RAYS_PER_CELL_EDGE), least);
}

/* Cell of a position; false outside. */
static bool locate(const np_transport_grid *g, const double p[3], size_t *out_cell) {
  int32_t at[3];
  for (int a = 0; a < 3; a++) {
    at[a] = np_transport_grid_locate(g, a, p[a]);
    if (at[a] == g->size[a] && g->is_wrapped[a]) at[a] = 0;
    if (at[a] < 0 || at[a] >= g->size[a]) return false;
  }
  *out_cell = np_transport_grid_join(g, at);
  return true;
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

static float sample_scaled(const sun_rays *r, np_dvec3 position) {
  float sum = 0.0f;
  for (unsigned v = 0; v < r->view->volume_count; v++)
    sum += np_transport_scale(&r->view->volumes[v], &r->phases[v], r->band) *
           np_view_extinction(&r->view->volumes[v], position);
  return sum;
}

/* A step from `t` on; where cells differ, no longer than half of one. */
static double find_step(const sun_rays *r, const double start[3], double t) {
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

/* `weight` is the ray's area over that of a cell's share in the units. */
static void follow_ray(const sun_rays *r, const double start[3], double weight) {
  const double exit = find_exit(r->grid, start, r->direction);
  double power = weight * 0x1p32;
  double t = 0.0;
  while (t < exit && power > weight * 0x1p14) {
    const double h = fmin(find_step(r, start, t), exit - t), middle = t + 0.5 * h;
    t += h;
    const double p[3] = {start[0] + middle * r->direction[0], start[1] + middle * r->direction[1],
                         start[2] + middle * r->direction[2]};
    const float extinction = sample_scaled(r, np_dvec3_make(p[0], p[1], p[2]));
    size_t cell;
    if (!(extinction > 0.0f) || !locate(r->grid, p, &cell)) continue;
    const double lost = -expm1(-(double)extinction * h) * power;
    (void)__atomic_fetch_add(&r->units[cell], (uint64_t)(lost + 0.5), __ATOMIC_RELAXED);
    power -= lost;
  }
}

static double fraction(double x) { return x - floor(x); }

static double find_length(const np_transport_grid *g, int axis) {
  return g->edge_m[axis][g->size[axis]] - g->edge_m[axis][0];
}

static void start_ray(const sun_rays *r, int axis, size_t number, size_t count) {
  const np_transport_grid *g = r->grid;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  double start[3];
  start[axis] = g->edge_m[axis][r->direction[axis] < 0.0 ? g->size[axis] : 0];
  start[b] = g->edge_m[b][0] + fraction(0.5 + 0.7548776662466927 * (double)number) * find_length(g, b);
  start[c] = g->edge_m[c][0] + fraction(0.5 + 0.5698402909980532 * (double)number) * find_length(g, c);
  const double face_cells = (double)g->size[b] * (double)g->size[c];
  /* Irradiance on the face times area, over the mean area of a cell's face. */
  follow_ray(r, start, fabs(r->direction[axis]) * face_cells / (double)count);
}

static neph_result follow_rays(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sun_rays *r = user;
  for (size_t number = begin; number < end; number++) {
    if (np_monitor_is_cancelled(r->monitor)) return NEPH_ERROR_CANCELLED;
    start_ray(r, r->face_axis, number, r->first[r->face_axis]);
  }
  return NEPH_OK;
}

static double find_volume(const np_transport_grid *g, int32_t cell) {
  int32_t at[3];
  double volume = 1.0;
  np_transport_grid_split(g, cell, at);
  for (int a = 0; a < 3; a++) volume *= np_transport_grid_width(g, a, at[a]);
  return volume;
}

/* Adds what one face's rays deposit. */
static neph_result light_face(sun_rays *r, int axis) {
  np_transport_grid *g = r->grid;
  r->face_axis = axis;
  r->first[axis] = count_face_rays(g, axis, r->direction);
  neph_result result = np_parallel_for(g->context, r->monitor, r->first[axis], 256, follow_rays, r);
  if (result) return result;
  double area = 1.0;
  for (int a = 0; a < 3; a++) area *= a == axis ? 1.0 : find_length(g, a) / g->size[a];
  for (size_t live = 0; live < g->live_count; live++) {
    uint64_t *units = &r->units[g->cell[live]];
    g->deposit[live] += (float)((double)*units * 0x1p-32 * area / find_volume(g, g->cell[live]));
    *units = 0;
  }
  return NEPH_OK;
}

neph_result np_transport_grid_light(const np_scene_view *view, const np_scaled_phase *phases, unsigned band,
                                    np_monitor *monitor, np_transport_grid *grid) {
  sun_rays r = {.view = view, .phases = phases, .band = band, .monitor = monitor, .grid = grid};
  const np_vec3 s = view->to_sun;
  const float length = np_vec3_length(s);
  if (!(length > 0.0f)) return NEPH_OK;
  r.direction[0] = -(double)(s.x / length);
  r.direction[1] = -(double)(s.y / length);
  r.direction[2] = -(double)(s.z / length);
  r.step_m = INFINITY;
  for (int a = 0; a < 3; a++) {
    r.step_m = fmin(r.step_m, 0.75 * np_transport_find_voxel(view, a));
    if (!grid->is_wrapped[a] && grid->even_m[a] > 0.0) r.step_m = fmin(r.step_m, 0.5 * grid->even_m[a]);
  }
  grid->deposit = np_alloc(grid->context, grid->live_count, sizeof *grid->deposit);
  r.units = np_alloc(grid->context, np_transport_grid_count(grid), sizeof *r.units);
  neph_result result = grid->deposit && r.units ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (int axis = 0; axis < 3 && !result; axis++) result = light_face(&r, axis);
  np_alloc_free(grid->context, r.units);
  return result;
}
