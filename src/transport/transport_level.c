/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered light on one grid: a sweep maps moments to those of its solution; their fixed point is sought. */
#include "transport/transport_level.h"

#include <string.h>

#include "core/alloc.h"

enum {
  CHUNK = 512,
  SWEEPS_MAX = 60,
  CHEAP_SWEEPS_MAX = 200,
  CHEAP_MOMENTS = 1 << 18, /* cells for which a solution costs so little that it is driven to the precision of floats */
  DEPTH = 3,
  CHEAP_DEPTH = NP_FIXED_POINT_DEPTH_MAX
};

/* Residual below which more exactness changes no picture. */
static const double cheap_tolerance_max = 2e-3;

/* Residuals to which cheap solutions are driven. Between periodic sides each sweep carries light through one period
 * alone, and the last digits of an endless field take hundreds of sweeps. */
static const double cheap_tolerance = 2e-6, cheap_periodic_tolerance = 5e-5;

bool np_transport_level_is_cheap(double moments, double tolerance) {
  return moments <= CHEAP_MOMENTS && tolerance <= cheap_tolerance_max;
}

unsigned np_transport_level_get_depth(double moments, double tolerance) {
  return np_transport_level_is_cheap(moments, tolerance) ? CHEAP_DEPTH : DEPTH;
}

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

neph_result np_transport_level_allocate(np_transport_level *level, bool is_emitting) {
  neph_context *context = level->grid.context;
  level->sun = np_alloc(context, level->grid.active_count, sizeof *level->sun);
  level->phi = np_alloc(context, count_moments(&level->grid), sizeof *level->phi);
  const size_t columns = (size_t)level->grid.size[0] * (size_t)level->grid.size[1];
  if (level->grid.has_ground) level->ground = np_alloc(context, columns, sizeof *level->ground);
  if (is_emitting) level->emission = np_alloc(context, level->grid.active_count, sizeof *level->emission);
  const bool has_own = (level->emission || !is_emitting) && (level->ground || !level->grid.has_ground);
  return level->sun && level->phi && has_own ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_transport_level_allocate_starts(np_transport_level *level, bool has_finer) {
  const size_t count = count_moments(&level->grid);
  level->first_phi = np_alloc(level->grid.context, count, sizeof *level->first_phi);
  if (has_finer) level->change = np_alloc(level->grid.context, count, sizeof *level->change);
  return level->first_phi && (level->change || !has_finer) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_transport_level_drop(np_transport_level *level) {
  np_alloc_free(level->grid.context, level->phi);
  level->phi = NULL;
}

void np_transport_level_clear(np_transport_level *level) {
  np_diffusion_clear(&level->diffusion);
  np_alloc_free(level->grid.context, level->sun);
  np_alloc_free(level->grid.context, level->ground);
  np_alloc_free(level->grid.context, level->emission);
  np_cell_air_clear(level->grid.context, &level->air);
  np_alloc_free(level->grid.context, level->phi);
  np_alloc_free(level->grid.context, level->first_phi);
  np_alloc_free(level->grid.context, level->change);
  np_transport_grid_clear(&level->grid);
  *level = (np_transport_level){0};
}

/* ---- One sweep ---- */

typedef struct iteration {
  const np_transport_lights *lights;
  const np_transport_level *level;
  const float *x;
  float *image, *source;         /* `source`: [active][harmonic], in the order of the ordinates; or where x is */
  np_sweep sweep;                /* its result may be where the image is */
  double *column;                /* scratch; NULL: no column */
  np_diffusion *diffusion;       /* NULL: plain sweeps */
  const np_fixed_point *problem; /* the problem of which the sweeps are a part; NULL: a sweep stands alone */
} iteration;

static neph_result fill_source(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const np_transport_grid *g = &it->level->grid;
  const np_transport_lights *lights = it->lights;
  const unsigned count = np_harmonics_count(g->degree);
  const unsigned char *place = lights->ordinates->place;
  for (size_t active = begin; active < end; active++) {
    const float *x = it->x + active * count, *ratio = g->ratio + active * (g->degree + 1);
    const float extinction = g->extinction[active], sun = it->level->sun[active];
    float source[NP_HARMONIC_COUNT_MAX];
    for (unsigned l = 0, i = 0; l <= g->degree; l++)
      for (; i < (l + 1) * (l + 1); i++)
        source[place[i]] = ratio[l] * (extinction * x[i] + sun * lights->sun_harmonics[i]);
    if (it->level->emission) source[place[0]] += it->level->emission[active];
    if (it->level->air.sunlit) source[place[0]] += np_transport_level_get_air(it->level, active);
    memcpy(it->source + active * count, source, count * sizeof *source);
  }
  return NEPH_OK;
}

static neph_result sort_moments(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const unsigned count = np_harmonics_count(it->level->grid.degree);
  const unsigned char *place = it->lights->ordinates->place;
  for (size_t active = begin; active < end; active++) {
    float swept[NP_HARMONIC_COUNT_MAX], *image = it->image + active * count;
    memcpy(swept, it->sweep.out + active * count, count * sizeof *swept);
    for (unsigned i = 0; i < count; i++) image[i] = swept[place[i]];
  }
  return NEPH_OK;
}

/* Share of all light below which light that crosses the periodic sides once more is neglected, and the limit on
 * crossings. */
static const double crossing_least = 1e-3;
enum { CROSSINGS_MAX = 12 };

/* Mean radiance of the last sweep, summed over the cells. */
static double sum_light(const iteration *it) {
  const size_t count = np_harmonics_count(it->level->grid.degree), first = it->lights->ordinates->place[0];
  double sum = 0.0;
  for (size_t active = 0; active < it->level->grid.active_count; active++)
    sum += (double)it->sweep.out[active * count + first];
  return sum;
}

/* Runs the sweeps. Light that leaves a periodic side enters with the next sweep. A single sweep is repeated until the
 * periodic sides are lit, iterations continue anyway. */
static neph_result run_sweeps(iteration *it) {
  const np_transport_grid *g = &it->level->grid;
  bool has_sides = false;
  for (int axis = 0; axis < 3; axis++) has_sides = has_sides || (g->is_wrapped[axis] && g->size[axis] > 1);
  const int most = has_sides && !it->problem ? CROSSINGS_MAX : 1;
  double before = 0.0;
  for (int n = 0; n < most; n++) {
    const neph_result result = np_sweep_run(&it->sweep);
    const double sum = result || most == 1 ? 0.0 : sum_light(it);
    if (result || !(sum > before * (1.0 + crossing_least))) return result;
    before = sum;
  }
  return NEPH_OK;
}

/* Sweeps light from `x` into `swept`, from there into `image`; `source` may be x, and `swept` the image. */
static neph_result sweep_moments(iteration *it, const float *x, float *source, float *swept, float *image) {
  const np_transport_lights *lights = it->lights;
  const size_t cells = it->level->grid.active_count;
  it->x = x;
  it->image = image;
  it->sweep.source = it->source = source;
  it->sweep.out = swept;
  neph_result result = np_parallel_for(lights->context, lights->monitor, cells, CHUNK, fill_source, it);
  if (!result) result = run_sweeps(it);
  if (!result) result = np_parallel_for(lights->context, lights->monitor, cells, CHUNK, sort_moments, it);
  if (!result && it->column) np_column_balance(lights, it->level, it->column, image);
  return result;
}

static neph_result map_moments(void *user, const float *x, float *scratch, float *out_image) {
  iteration *it = user;
  const neph_result result = sweep_moments(it, x, scratch, out_image, out_image);
  if (!result && it->diffusion && !it->problem->is_stalled) np_diffusion_correct(it->diffusion, x, out_image);
  return result;
}

static void clear_iteration(iteration *it) {
  np_alloc_free(it->lights->context, it->column);
  np_sweep_clear(&it->sweep);
}

/* The workspace gets `vectors` like `phi`. On failure nothing is left. */
static neph_result start_iteration(const np_transport_lights *lights, np_transport_level *level, unsigned vectors,
                                   iteration *out) {
  neph_context *context = lights->context;
  const np_transport_grid *g = &level->grid;
  const bool is_column = np_transport_grid_is_column(g);
  *out = (iteration){.lights = lights, .level = level};
  neph_result result = np_sweep_init(context, lights->monitor, g, lights->ordinates, &level->air, &out->sweep);
  if (result) return result;
  result = np_workspace_begin(lights->workspace, count_moments(g) * vectors, vectors);
  if (!result && is_column) out->column = np_alloc(context, g->active_count, NP_COLUMN_SCRATCH * sizeof *out->column);
  if (!result && is_column && !out->column) result = NEPH_ERROR_OUT_OF_MEMORY;
  if (result) return clear_iteration(out), result;
  out->sweep.border = lights->border;
  out->sweep.ground = level->ground;
  return NEPH_OK;
}

static double get_cheap_tolerance(const np_transport_grid *g) {
  bool has_sides = false;
  for (int axis = 0; axis < 3; axis++) has_sides = has_sides || (g->is_wrapped[axis] && g->size[axis] > 1);
  return has_sides ? cheap_periodic_tolerance : cheap_tolerance;
}

neph_result np_transport_level_solve(const np_transport_lights *lights, np_transport_level *level,
                                     np_transport_effort *effort) {
  const size_t moments = count_moments(&level->grid);
  const bool is_cheap = np_transport_level_is_cheap((double)moments, effort->tolerance);
  const unsigned depth =
      np_transport_grid_is_column(&level->grid) ? 1 : np_transport_level_get_depth((double)moments, effort->tolerance);
  iteration it;
  neph_result result = start_iteration(lights, level, 2 * depth, &it);
  if (result) return result;
  np_fixed_point problem = {.context = lights->context,
                            .monitor = lights->monitor,
                            .map = map_moments,
                            .user = &it,
                            .count = moments,
                            .depth = depth,
                            .vectors = np_workspace_take(lights->workspace, 2 * depth * moments),
                            .tolerance = is_cheap ? fmin(effort->tolerance, get_cheap_tolerance(&level->grid))
                                                  : effort->tolerance,
                            .calls_max = is_cheap || !effort->is_finest ? CHEAP_SWEEPS_MAX : SWEEPS_MAX,
                            .keeper = effort->keeper};
  if (effort->sweeps_max) problem.calls_max = effort->sweeps_max;
  it.problem = &problem;
  if (!it.column) it.diffusion = &level->diffusion;
  if (!it.column && !level->diffusion.grid) result = np_diffusion_init(&level->grid, &level->diffusion);
  if (!result) result = np_fixed_point_solve(&problem, level->phi);
  effort->residual = problem.residual;
  effort->sweeps = problem.calls;
  effort->is_cut = problem.is_cut;
  if (!result && effort->outflow && problem.calls > 0 && !problem.is_cut)
    np_sweep_measure_outflow(&it.sweep, effort->outflow);
  clear_iteration(&it);
  return result;
}

neph_result np_transport_level_sweep(const np_transport_lights *lights, np_transport_level *level, bool has_budget) {
  iteration it;
  neph_result result = start_iteration(lights, level, has_budget ? 2 : 1, &it);
  if (result) return result;
  const size_t moments = count_moments(&level->grid);
  float *swept = np_workspace_take(lights->workspace, moments);
  float *source = has_budget ? np_workspace_take(lights->workspace, moments) : level->phi;
  result = sweep_moments(&it, level->phi, source, swept, level->phi);
  clear_iteration(&it);
  return result == NEPH_ERROR_CANCELLED && np_monitor_is_cut(lights->monitor) ? NEPH_OK : result;
}

/* ---- Steps between grids, and to the eye ---- */

typedef struct prolongation {
  const np_transport_grid *coarse;
  const float *values; /* values on the coarser grid */
  np_transport_level *fine;
  float kept; /* factor on the existing values: 0 or 1 */
} prolongation;

static neph_result prolong_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const prolongation *p = user;
  const np_transport_level *fine = p->fine;
  const unsigned count = np_harmonics_count(fine->grid.degree);
  for (size_t active = begin; active < end; active++) {
    int32_t near[8];
    float weight[8], *out = fine->phi + active * count;
    const np_dvec3 centre = np_transport_grid_centre(&fine->grid, fine->grid.cell[active]);
    const unsigned found = np_transport_grid_get_corners(p->coarse, centre, near, weight);
    for (unsigned i = 0; i < count; i++) out[i] *= p->kept;
    for (unsigned c = 0; c < found; c++)
      for (unsigned i = 0; i < count; i++) out[i] += weight[c] * p->values[(size_t)near[c] * count + i];
  }
  return NEPH_OK;
}

neph_result np_transport_level_prolong(const np_transport_level *coarse, np_monitor *monitor,
                                       np_transport_level *fine) {
  prolongation p = {&coarse->grid, coarse->phi, fine, 0.0f};
  return np_parallel_for(fine->grid.context, monitor, fine->grid.active_count, CHUNK, prolong_cells, &p);
}

neph_result np_transport_level_prolong_change(const np_transport_level *coarse, np_transport_level *fine) {
  prolongation p = {&coarse->grid, coarse->change, fine, 1.0f};
  return np_parallel_for(fine->grid.context, NULL, fine->grid.active_count, CHUNK, prolong_cells, &p);
}

/* Sunlight in a cell that has gone straight on, weighted by extinction: first collisions over it. */
static float compute_direct_irradiance(const np_transport_level *level, size_t active) {
  const float extinction = level->grid.extinction[active];
  return extinction > 0.0f ? level->sun[active] / extinction : 0.0f;
}

typedef struct resolution {
  const np_transport_lights *lights;
  const np_transport_level *broad;
  np_transport_level *fine;
} resolution;

/* The peak that only `broad` counts as straight has, in units of its share of all scattering, the moments 1 up to the
 * degree n + 1 and r_l/r_{n+1} above: nearly all of that light has been scattered by it once. */
static void resolve_cell(const resolution *r, size_t active) {
  const np_transport_level *broad = r->broad, *fine = r->fine;
  const unsigned count = np_harmonics_count(fine->grid.degree), known = np_harmonics_count(broad->grid.degree);
  const unsigned peak = broad->grid.degree + 1;
  const float *ratio = fine->grid.ratio + active * (fine->grid.degree + 1);
  const float more = fmaxf(0.0f, compute_direct_irradiance(broad, active) - compute_direct_irradiance(fine, active));
  float *phi = fine->phi + active * count;
  for (unsigned l = 0, i = 0; l <= fine->grid.degree; l++) {
    const float share = l <= peak ? 1.0f : ratio[peak] > 0.0f ? np_clampf(ratio[l] / ratio[peak], 0.0f, 1.0f) : 0.0f;
    for (; i < (l + 1) * (l + 1); i++)
      phi[i] = (i < known ? broad->phi[active * known + i] : 0.0f) + share * more * r->lights->sun_harmonics[i];
  }
}

static neph_result resolve_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t active = begin; active < end; active++) resolve_cell(user, active);
  return NEPH_OK;
}

neph_result np_transport_level_resolve(const np_transport_lights *lights, const np_transport_level *broad,
                                       np_transport_level *fine) {
  resolution r = {lights, broad, fine};
  return np_parallel_for(fine->grid.context, NULL, fine->grid.active_count, CHUNK, resolve_cells, &r);
}

/* Shares of the second differences: an eighth for even cells; elsewhere φ″ by the parabola through three middles. */
static void compute_shares(const np_transport_grid *g, int axis, int32_t at, float *out_down, float *out_up) {
  *out_down = *out_up = 0.125f;
  if (g->even_m[axis] > 0.0) return;
  const double width = np_transport_grid_width(g, axis, at);
  const double low = 0.5 * (width + np_transport_grid_width(g, axis, at - 1));
  const double high = 0.5 * (width + np_transport_grid_width(g, axis, at + 1));
  *out_down = (float)(0.25 * width * width / (low * (low + high)));
  *out_up = (float)(0.25 * width * width / (high * (low + high)));
}

/* Sharpens a line of cells along an axis in place; the original value of each cell is kept for the next one. */
static void sharpen_line(const np_transport_grid *g, int axis, const int32_t first[3], unsigned count, float *values) {
  const size_t bytes = count * sizeof *values;
  const int32_t size = g->size[axis];
  int32_t at[3] = {first[0], first[1], first[2]};
  float begin[NP_HARMONIC_COUNT_MAX], before[NP_HARMONIC_COUNT_MAX], own[NP_HARMONIC_COUNT_MAX];
  at[axis] = g->is_wrapped[axis] ? size - 1 : 0;
  const int32_t last = g->active[np_transport_grid_join(g, at)], head = g->active[np_transport_grid_join(g, first)];
  if (last >= 0) memcpy(before, values + (size_t)last * count, bytes);
  if (head >= 0) memcpy(begin, values + (size_t)head * count, bytes);
  for (at[axis] = 0; at[axis] < size; at[axis]++) {
    const int32_t active = g->active[np_transport_grid_join(g, at)];
    if (active < 0) continue;
    const int32_t below = np_transport_grid_neighbour(g, at, axis, -1);
    const int32_t above = np_transport_grid_neighbour(g, at, axis, 1);
    float *middle = values + (size_t)active * count;
    memcpy(own, middle, bytes);
    if (below >= 0 && above >= 0) {
      const float *next = at[axis] + 1 < size ? values + (size_t)above * count : begin;
      float down, up;
      compute_shares(g, axis, at[axis], &down, &up);
      for (unsigned i = 0; i < count; i++) middle[i] -= down * (before[i] - own[i]) + up * (next[i] - own[i]);
    }
    memcpy(before, own, bytes);
  }
}

/* Arguments of the loop over lines along one axis, which are independent of each other. */
typedef struct sharpening {
  const np_transport_grid *grid;
  int axis;
  unsigned count;
  float *values;
} sharpening;

static neph_result sharpen_planes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sharpening *s = user;
  const int u = s->axis == 0 ? 1 : 0, v = s->axis == 2 ? 1 : 2;
  int32_t first[3] = {0};
  for (first[v] = (int32_t)begin; first[v] < (int32_t)end; first[v]++)
    for (first[u] = 0; first[u] < s->grid->size[u]; first[u]++)
      sharpen_line(s->grid, s->axis, first, s->count, s->values);
  return NEPH_OK;
}

neph_result np_transport_grid_sharpen(const np_transport_grid *grid, unsigned count, np_monitor *monitor,
                                      float *values) {
  neph_result result = NEPH_OK;
  for (int axis = 0; axis < 3 && !result; axis++) {
    sharpening s = {grid, axis, count, values};
    const size_t planes = (size_t)grid->size[axis == 2 ? 1 : 2];
    if (grid->size[axis] > 1) result = np_parallel_for(grid->context, monitor, planes, 1, sharpen_planes, &s);
  }
  return result;
}
