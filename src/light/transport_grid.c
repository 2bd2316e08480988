/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of the multiple scattering: where they lie, what they hold.
 *
 * Their error grows with x = (1−g)·σ·edge, to some 2 % at 0.3 and 4 % at 1, so the densest cloud decides their size;
 * two voxels at least, since the field's own detail ends there, unless a single voxel is thicker than that or one
 * voxel to a cell costs next to nothing.
 */
#include "light/transport_grid.h"

#include <string.h>

#include "core/alloc.h"
#include "light/emission.h"

/* ---- Where ---- */

/* The index axis that a world axis runs along alone; −1 when the volume is turned. */
static int find_index_axis(const np_view_volume *volume, int world_axis) {
  int found = -1;
  for (int a = 0; a < 3; a++) {
    double others = 0.0;
    for (int j = 0; j < 3; j++)
      if (j != world_axis) others += fabs(volume->world_to_index.m[a][j]);
    if (fabs(volume->world_to_index.m[a][world_axis]) > 1e6 * others) found = a;
  }
  return found;
}

/* Finest spacing of samples along a world axis. */
static double find_voxel(const np_scene_view *view, int axis) {
  double finest = INFINITY;
  for (unsigned v = 0; v < view->volume_count; v++) {
    const double(*m)[4] = view->volumes[v].world_to_index.m;
    finest = fmin(finest, 1.0 / sqrt(m[0][axis] * m[0][axis] + m[1][axis] * m[1][axis] + m[2][axis] * m[2][axis]));
  }
  return finest;
}

/* (1−g)·σ at the densest point. */
static double find_transport_extinction(const np_scene_view *view) {
  double densest = 0.0;
  for (unsigned v = 0; v < view->volume_count; v++) {
    const np_view_volume *volume = &view->volumes[v];
    const double extinction = (double)(volume->bricks->value_max * volume->extinction_per_value);
    densest = fmax(densest, (1.0 - fmax(0.0, np_phase_mean_cosine(&volume->phase))) * extinction);
  }
  return densest;
}

static bool is_wrapped_along(const np_scene_view *view, int axis, double *out_period_m) {
  if (view->volume_count != 1) return false;
  const np_view_volume *volume = &view->volumes[0];
  const int a = find_index_axis(volume, axis);
  if (a < 0 || a > 1 || !volume->bricks->is_periodic[a]) return false;
  *out_period_m = volume->bricks->period[a] / fabs(volume->world_to_index.m[a][axis]);
  return true;
}

/* One axis, with cells of `edge_voxels`: lines of cells on samples of the first cloud, one empty cell at either end,
 * and a count that three coarser grids divide. A period of up to a brick becomes one cell. */
static void place_axis(const np_scene_view *view, const np_transport_desc *desc, int axis, double edge_voxels,
                       np_transport_grid *grid) {
  enum { COARSEST = 8 };
  const double low[3] = {desc->bounds_min.x, desc->bounds_min.y, desc->bounds_min.z};
  const double high[3] = {desc->bounds_max.x, desc->bounds_max.y, desc->bounds_max.z};
  const double voxel = find_voxel(view, axis), edge = edge_voxels * voxel;
  const np_view_volume *first = &view->volumes[0];
  const int a = find_index_axis(first, axis);
  const double base = a < 0 ? low[axis] : -first->world_to_index.m[a][3] / first->world_to_index.m[a][axis];
  double period;
  grid->is_wrapped[axis] = is_wrapped_along(view, axis, &period);
  if (grid->is_wrapped[axis]) {
    const int32_t cells = (int32_t)(period / edge);
    grid->size[axis] = period <= NP_BRICK_EDGE * 1.001 * voxel || cells < COARSEST ? 1 : cells / COARSEST * COARSEST;
    grid->cell_m[axis] = period / grid->size[axis];
    grid->origin_m[axis] = base;
    return;
  }
  grid->cell_m[axis] = edge;
  grid->origin_m[axis] = base + floor((low[axis] - base) / voxel - 1.0) * voxel - edge;
  const double cells = ceil((high[axis] + voxel - grid->origin_m[axis]) / edge) + 1.0;
  grid->size[axis] = (int32_t)fmin(ceil(cells / COARSEST) * COARSEST, 1e6);
}

/* (1−g)·σ over the longest edge of a voxel; an axis of a single cell does not count. */
static double find_voxel_depth(const np_scene_view *view) {
  double longest = 0.0, period;
  for (int axis = 0; axis < 3; axis++) {
    const double voxel = find_voxel(view, axis);
    const bool is_single = is_wrapped_along(view, axis, &period) && period <= NP_BRICK_EDGE * 1.001 * voxel;
    if (!is_single) longest = fmax(longest, voxel);
  }
  return find_transport_extinction(view) * longest;
}

static double place_cells(const np_scene_view *view, const np_transport_desc *desc, double edge_voxels,
                          np_transport_grid *grid) {
  for (int axis = 0; axis < 3; axis++) place_axis(view, desc, axis, edge_voxels, grid);
  return (double)grid->size[0] * grid->size[1] * grid->size[2];
}

void np_transport_grid_place(const np_scene_view *view, const np_transport_desc *desc, np_transport_grid *grid) {
  const double voxel_depth = find_voxel_depth(view);
  double edge = place_cells(view, desc, 1.0, grid) <= (double)desc->cell_count_cheap ? 1.0 : 2.0;
  while (edge < 8.0 && 1.5 * edge * voxel_depth <= 0.5 * desc->cell_depth_max) edge *= 1.5;
  while (edge > 0.1 && edge * voxel_depth > 3.5 * desc->cell_depth_max) edge *= 0.5;
  for (;; edge *= 1.25) {
    const double rounded = edge > 2.0 ? ceil(4.0 * edge) * 0.25 : edge;
    if (place_cells(view, desc, rounded, grid) <= (double)desc->cell_count_max) return;
  }
}

/* ---- What they hold ---- */

/* Scaled extinction, and the scaled scattering moments, at a point. */
typedef struct material {
  float extinction, scattering[NP_HARMONIC_DEGREES];
  bool glows;
} material;

static float scale_of(const np_view_volume *volume, const np_scaled_phase *phase, unsigned band) {
  return 1.0f - volume->albedo.band[band] * phase->forward;
}

static void add_material(const np_scene_view *view, const np_scaled_phase *phases, unsigned band, np_dvec3 position,
                         float weight, material *out) {
  for (unsigned v = 0; v < view->volume_count; v++) {
    const np_view_volume *volume = &view->volumes[v];
    const float extinction = weight * np_view_extinction(volume, position);
    if (!(extinction > 0.0f)) continue;
    out->extinction += extinction * scale_of(volume, &phases[v], band);
    for (int l = 0; l < NP_HARMONIC_DEGREES; l++)
      out->scattering[l] += extinction * volume->albedo.band[band] * phases[v].moments[l];
  }
}

typedef struct fill {
  const np_scene_view *view;
  const np_scaled_phase *phases;
  unsigned band;
  np_monitor *monitor;
  np_transport_grid *grid;
  int32_t points[3]; /* along each axis of a cell */
  material *materials;
} fill;

float np_transport_grid_average_emission(const np_transport_grid *grid, const struct np_emission *emission,
                                         const int32_t cell[3], unsigned band) {
  const double *o = grid->origin_m, *size = grid->cell_m;
  const np_dvec3 low = np_dvec3_make(o[0] + cell[0] * size[0], o[1] + cell[1] * size[1], o[2] + cell[2] * size[2]);
  return np_emission_average(emission, low, np_dvec3_make(size[0], size[1], size[2])).band[band];
}

/* Mean over a cell by the midpoint rule on the pieces between samples, where the interpolant is trilinear and the rule
 * exact; over large cells on a coarser lattice. */
static void average_cell(const fill *f, const int32_t cell[3], material *out) {
  const np_transport_grid *g = f->grid;
  const float weight = 1.0f / (float)(f->points[0] * f->points[1] * f->points[2]);
  *out = (material){0};
  for (int32_t k = 0; k < f->points[2]; k++)
    for (int32_t j = 0; j < f->points[1]; j++)
      for (int32_t i = 0; i < f->points[0]; i++) {
        const np_dvec3 position = np_dvec3_make(g->origin_m[0] + (cell[0] + (i + 0.5) / f->points[0]) * g->cell_m[0],
                                                g->origin_m[1] + (cell[1] + (j + 0.5) / f->points[1]) * g->cell_m[1],
                                                g->origin_m[2] + (cell[2] + (k + 0.5) / f->points[2]) * g->cell_m[2]);
        add_material(f->view, f->phases, f->band, position, weight, out);
      }
  if (f->view->emission) out->glows = np_transport_grid_average_emission(g, f->view->emission, cell, f->band) > 0.0f;
}

static neph_result average_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const fill *f = user;
  const int32_t *size = f->grid->size;
  for (size_t row = begin; row < end; row++) {
    if (np_monitor_is_cancelled(f->monitor)) return NEPH_ERROR_CANCELLED;
    for (int32_t i = 0; i < size[0]; i++) {
      const int32_t cell[3] = {i, (int32_t)(row % (size_t)size[1]), (int32_t)(row / (size_t)size[1])};
      average_cell(f, cell, &f->materials[row * (size_t)size[0] + (size_t)i]);
    }
  }
  return NEPH_OK;
}

/* Whether a cell or one that touches it holds cloud, or something that glows. */
static bool is_live(const np_transport_grid *g, const material *materials, int32_t cell) {
  const int32_t at[3] = {cell % g->size[0], cell / g->size[0] % g->size[1], cell / g->size[0] / g->size[1]};
  for (int32_t n = 0; n < 27; n++) {
    int32_t near[3] = {at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1};
    bool is_inside = true;
    for (int a = 0; a < 3; a++) {
      if (g->is_wrapped[a]) near[a] = (near[a] + g->size[a]) % g->size[a];
      is_inside = is_inside && near[a] >= 0 && near[a] < g->size[a];
    }
    if (!is_inside) continue;
    const material *m = &materials[(near[2] * g->size[1] + near[1]) * g->size[0] + near[0]];
    if (m->extinction > 0.0f || m->glows) return true;
  }
  return false;
}

static size_t count_cells(const np_transport_grid *g) {
  return (size_t)g->size[0] * (size_t)g->size[1] * (size_t)g->size[2];
}

static neph_result allocate_live(np_transport_grid *g) {
  g->cell = np_alloc(g->context, g->live_count, sizeof *g->cell);
  g->extinction = np_alloc(g->context, g->live_count, sizeof *g->extinction);
  g->ratio = np_alloc(g->context, g->live_count, sizeof *g->ratio);
  return g->cell && g->extinction && g->ratio ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Cells without cloud get the ratios of the first cloud: what is multiplied by them is 0. */
static void keep_material(np_transport_grid *g, size_t live, const material *m, const float fallback[]) {
  g->extinction[live] = m->extinction;
  for (int l = 0; l < NP_HARMONIC_DEGREES; l++)
    g->ratio[live][l] = m->extinction > 0.0f ? m->scattering[l] / m->extinction : fallback[l];
}

static neph_result keep_live(const fill *f) {
  np_transport_grid *g = f->grid;
  const int32_t cells = (int32_t)count_cells(g);
  for (int32_t c = 0; c < cells; c++)
    g->live[c] = is_live(g, f->materials, c) ? (int32_t)g->live_count++ : NP_TRANSPORT_CELL_NONE;
  neph_result result = allocate_live(g);
  if (result) return result;
  const np_view_volume *first = &f->view->volumes[0];
  float fallback[NP_HARMONIC_DEGREES];
  for (int l = 0; l < NP_HARMONIC_DEGREES; l++)
    fallback[l] = first->albedo.band[f->band] * f->phases[0].moments[l] / scale_of(first, &f->phases[0], f->band);
  for (int32_t c = 0; c < cells; c++) {
    if (g->live[c] < 0) continue;
    g->cell[g->live[c]] = c;
    keep_material(g, (size_t)g->live[c], &f->materials[c], fallback);
  }
  return NEPH_OK;
}

neph_result np_transport_grid_fill(const np_scene_view *view, const np_scaled_phase *phases, unsigned band,
                                   np_monitor *monitor, np_transport_grid *grid) {
  fill f = {view, phases, band, monitor, grid, {0}, NULL};
  for (int a = 0; a < 3; a++)
    f.points[a] = (int32_t)np_clamp(ceil(grid->cell_m[a] / find_voxel(view, a) - 0.01), 1.0, 4.0);
  f.materials = np_alloc(grid->context, count_cells(grid), sizeof *f.materials);
  grid->live = np_alloc(grid->context, count_cells(grid), sizeof *grid->live);
  neph_result result = f.materials && grid->live ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result)
    result = np_parallel_for(grid->context, monitor, (size_t)(grid->size[1] * grid->size[2]), 4, average_rows, &f);
  if (!result) result = keep_live(&f);
  np_alloc_free(grid->context, f.materials);
  return result;
}

/* ---- First collisions ---- */

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
  double step_m;
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
    double u = (p[a] - g->origin_m[a]) / g->cell_m[a];
    if (g->is_wrapped[a]) u -= floor(u / g->size[a]) * g->size[a];
    at[a] = (int32_t)np_clamp(floor(u), -1.0, (double)g->size[a]);
    if (at[a] == g->size[a] && g->is_wrapped[a]) at[a] = 0;
    if (at[a] < 0 || at[a] >= g->size[a]) return false;
  }
  *out_cell = ((size_t)at[2] * (size_t)g->size[1] + (size_t)at[1]) * (size_t)g->size[0] + (size_t)at[0];
  return true;
}

static double find_exit(const np_transport_grid *g, const double p[3], const double d[3]) {
  double exit = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (g->is_wrapped[a] || fabs(d[a]) < 1e-12) continue;
    const double plane = d[a] > 0.0 ? g->origin_m[a] + g->size[a] * g->cell_m[a] : g->origin_m[a];
    exit = fmin(exit, (plane - p[a]) / d[a]);
  }
  return exit;
}

static float sample_scaled(const sun_rays *r, np_dvec3 position) {
  float sum = 0.0f;
  for (unsigned v = 0; v < r->view->volume_count; v++)
    sum += scale_of(&r->view->volumes[v], &r->phases[v], r->band) * np_view_extinction(&r->view->volumes[v], position);
  return sum;
}

/* `weight` is the ray's area over that of a cell's share in the units. */
static void follow_ray(const sun_rays *r, const double start[3], double weight) {
  const double exit = find_exit(r->grid, start, r->direction);
  double power = weight * 0x1p32;
  for (double t = 0.0; t < exit && power > weight * 0x1p14; t += r->step_m) {
    const double h = fmin(r->step_m, exit - t), middle = t + 0.5 * h;
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

static void start_ray(const sun_rays *r, int axis, size_t number, size_t count) {
  const np_transport_grid *g = r->grid;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  double start[3];
  start[axis] = g->origin_m[axis] + (r->direction[axis] < 0.0 ? g->size[axis] * g->cell_m[axis] : 0.0);
  start[b] = g->origin_m[b] + fraction(0.5 + 0.7548776662466927 * (double)number) * g->size[b] * g->cell_m[b];
  start[c] = g->origin_m[c] + fraction(0.5 + 0.5698402909980532 * (double)number) * g->size[c] * g->cell_m[c];
  const double face_cells = (double)g->size[b] * (double)g->size[c];
  /* Irradiance on the face times area, over the cell's volume, but for the 1/edge along the face's axis. */
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

/* Adds what one face's rays deposit. */
static neph_result light_face(sun_rays *r, int axis) {
  np_transport_grid *g = r->grid;
  r->face_axis = axis;
  r->first[axis] = count_face_rays(g, axis, r->direction);
  neph_result result = np_parallel_for(g->context, r->monitor, r->first[axis], 256, follow_rays, r);
  if (result) return result;
  for (size_t live = 0; live < g->live_count; live++) {
    uint64_t *units = &r->units[g->cell[live]];
    g->deposit[live] += (float)((double)*units * 0x1p-32 / g->cell_m[axis]);
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
    r.step_m = fmin(r.step_m, 0.75 * find_voxel(view, a));
    if (!grid->is_wrapped[a]) r.step_m = fmin(r.step_m, 0.5 * grid->cell_m[a]);
  }
  grid->deposit = np_alloc(grid->context, grid->live_count, sizeof *grid->deposit);
  r.units = np_alloc(grid->context, count_cells(grid), sizeof *r.units);
  neph_result result = grid->deposit && r.units ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (int axis = 0; axis < 3 && !result; axis++) result = light_face(&r, axis);
  np_alloc_free(grid->context, r.units);
  return result;
}

/* ---- Coarser ---- */

bool np_transport_grid_can_coarsen(const np_transport_grid *grid) {
  bool is_even = true, has_many = false;
  for (int a = 0; a < 3; a++) {
    is_even = is_even && (grid->size[a] == 1 || grid->size[a] % 2 == 0);
    has_many = has_many || grid->size[a] >= 4;
  }
  return is_even && has_many;
}

/* The coarse cell that holds a fine one. */
static size_t parent_of(const np_transport_grid *fine, const np_transport_grid *coarse, int32_t cell) {
  int32_t at[3] = {cell % fine->size[0], cell / fine->size[0] % fine->size[1], cell / fine->size[0] / fine->size[1]};
  for (int a = 0; a < 3; a++) at[a] = fine->size[a] == 1 ? 0 : at[a] / 2;
  return ((size_t)at[2] * (size_t)coarse->size[1] + (size_t)at[1]) * (size_t)coarse->size[0] + (size_t)at[0];
}

static float child_share(const np_transport_grid *fine) {
  float share = 1.0f;
  for (int a = 0; a < 3; a++) share *= fine->size[a] == 1 ? 1.0f : 0.5f;
  return share;
}

void np_transport_grid_restrict(const np_transport_grid *fine, const float *values, unsigned width,
                                const np_transport_grid *coarse, float *out) {
  const float share = child_share(fine);
  memset(out, 0, coarse->live_count * width * sizeof *out);
  for (size_t i = 0; i < fine->live_count; i++) {
    const size_t parent = (size_t)coarse->live[parent_of(fine, coarse, fine->cell[i])];
    for (unsigned w = 0; w < width; w++) out[parent * width + w] += share * values[i * width + w];
  }
}

static void number_parents(const np_transport_grid *fine, np_transport_grid *out) {
  for (size_t i = 0; i < fine->live_count; i++) out->live[parent_of(fine, out, fine->cell[i])] = 1;
  for (size_t c = 0; c < count_cells(out); c++)
    out->live[c] = out->live[c] ? (int32_t)out->live_count++ : NP_TRANSPORT_CELL_NONE;
}

/* Extinction and scattering are averaged; their ratio follows. */
static void average_children(const np_transport_grid *fine, np_transport_grid *out) {
  const float share = child_share(fine);
  for (size_t c = 0; c < count_cells(out); c++)
    if (out->live[c] >= 0) out->cell[out->live[c]] = (int32_t)c;
  for (size_t i = 0; i < fine->live_count; i++) {
    const size_t parent = (size_t)out->live[parent_of(fine, out, fine->cell[i])];
    const float before = out->extinction[parent], added = share * fine->extinction[i];
    const float t = added > 0.0f ? added / (before + added) : before > 0.0f ? 0.0f : 1.0f;
    for (int l = 0; l < NP_HARMONIC_DEGREES; l++)
      out->ratio[parent][l] += t * (fine->ratio[i][l] - out->ratio[parent][l]);
    out->extinction[parent] = before + added;
  }
}

neph_result np_transport_grid_coarsen(const np_transport_grid *fine, np_transport_grid *out) {
  *out = (np_transport_grid){.context = fine->context};
  for (int a = 0; a < 3; a++) {
    const bool is_single = fine->size[a] == 1;
    out->size[a] = is_single ? 1 : fine->size[a] / 2;
    out->cell_m[a] = is_single ? fine->cell_m[a] : 2.0 * fine->cell_m[a];
    out->origin_m[a] = fine->origin_m[a];
    out->is_wrapped[a] = fine->is_wrapped[a];
  }
  out->live = np_alloc(out->context, count_cells(out), sizeof *out->live);
  if (!out->live) return NEPH_ERROR_OUT_OF_MEMORY;
  number_parents(fine, out);
  neph_result result = allocate_live(out);
  if (!result) average_children(fine, out);
  return result;
}

void np_transport_grid_clear(np_transport_grid *grid) {
  np_alloc_free(grid->context, grid->live);
  np_alloc_free(grid->context, grid->cell);
  np_alloc_free(grid->context, grid->extinction);
  np_alloc_free(grid->context, grid->ratio);
  np_alloc_free(grid->context, grid->deposit);
  *grid = (np_transport_grid){0};
}
