/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered light on one grid: a sweep maps moments to those of its solution; their fixed point is sought. */
#include "light/transport_level.h"

#include <string.h>

#include "core/alloc.h"
#include "light/fixed_point.h"

enum {
  CHUNK = 4096,
  SWEEPS_MAX = 60,
  CHEAP_SWEEPS_MAX = 200,
  CHEAP_MOMENTS = 1 << 18, /* for which a solution costs so little that it is driven to the end of floats */
  DEPTH = 5,
  CHEAP_DEPTH = NP_FIXED_POINT_DEPTH_MAX
};

static size_t count_moments(const np_transport_grid *g) { return g->live_count * np_harmonics_count(g->degree); }

neph_result np_transport_level_allocate(np_transport_level *level, bool glows) {
  neph_context *context = level->grid.context;
  level->sun = np_alloc(context, level->grid.live_count, sizeof *level->sun);
  level->phi = np_alloc(context, count_moments(&level->grid), sizeof *level->phi);
  if (glows) level->glow = np_alloc(context, level->grid.live_count, sizeof *level->glow);
  return level->sun && level->phi && (level->glow || !glows) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_transport_level_clear(np_transport_level *level) {
  np_alloc_free(level->grid.context, level->sun);
  np_alloc_free(level->grid.context, level->glow);
  np_alloc_free(level->grid.context, level->phi);
  np_transport_grid_clear(&level->grid);
  *level = (np_transport_level){0};
}

/* ---- One sweep ---- */

typedef struct iteration {
  const np_transport_lights *lights;
  const np_transport_level *level;
  const float *x;
  float *image;
  float *source; /* [live][harmonic], in the order of the ordinates */
  np_sweep sweep;
  double *column; /* scratch; NULL: no column */
} iteration;

static neph_result fill_source(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const np_transport_grid *g = &it->level->grid;
  const np_transport_lights *lights = it->lights;
  const unsigned count = np_harmonics_count(g->degree);
  const unsigned char *place = lights->ordinates->place;
  for (size_t live = begin; live < end; live++) {
    const float *x = it->x + live * count, *ratio = g->ratio + live * (g->degree + 1);
    const float extinction = g->extinction[live], sun = it->level->sun[live];
    float *source = it->source + live * count;
    for (unsigned l = 0, i = 0; l <= g->degree; l++)
      for (; i < (l + 1) * (l + 1); i++)
        source[place[i]] = ratio[l] * (extinction * x[i] + sun * lights->sun_harmonics[i]);
    if (it->level->glow) source[place[0]] += it->level->glow[live];
  }
  return NEPH_OK;
}

/* Adds the pairs of octants in their order, whoever swept them. */
static neph_result add_pairs(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const unsigned count = np_harmonics_count(it->level->grid.degree);
  const unsigned char *place = it->lights->ordinates->place;
  for (size_t live = begin; live < end; live++)
    for (unsigned i = 0; i < count; i++) {
      const size_t at = live * count + place[i];
      float sum = it->sweep.out[0][at];
      for (size_t pair = 1; pair < NP_OCTANT_PAIRS; pair++) sum += it->sweep.out[pair][at];
      it->image[live * count + i] = sum;
    }
  return NEPH_OK;
}

static neph_result map_moments(void *user, const float *x, float *out_image) {
  iteration *it = user;
  const np_transport_lights *lights = it->lights;
  const np_transport_grid *g = &it->level->grid;
  it->x = x;
  it->image = out_image;
  neph_result result = np_parallel_for(lights->context, lights->monitor, g->live_count, CHUNK, fill_source, it);
  if (!result) result = np_sweep_run(&it->sweep);
  if (!result) result = np_parallel_for(lights->context, lights->monitor, g->live_count, CHUNK, add_pairs, it);
  if (!result && it->column) np_column_balance(lights, it->level, it->column, out_image);
  return result;
}

neph_result np_transport_level_solve(const np_transport_lights *lights, np_transport_level *level,
                                     np_transport_effort *effort) {
  neph_context *context = lights->context;
  const size_t moments = count_moments(&level->grid);
  const bool is_column = np_transport_grid_is_column(&level->grid), is_cheap = moments <= CHEAP_MOMENTS;
  iteration it = {.lights = lights, .level = level};
  neph_result result = np_sweep_init(context, lights->monitor, &level->grid, lights->ordinates, &it.sweep);
  if (result) return result;
  it.source = np_alloc(context, moments, sizeof *it.source);
  if (is_column) it.column = np_alloc(context, level->grid.live_count, NP_COLUMN_SCRATCH * sizeof *it.column);
  it.sweep.source = it.source;
  it.sweep.inflow = lights->inflow;
  np_fixed_point problem = {.context = context,
                            .monitor = lights->monitor,
                            .map = map_moments,
                            .user = &it,
                            .count = moments,
                            .depth = is_column  ? 1
                                     : is_cheap ? CHEAP_DEPTH
                                                : DEPTH,
                            .tolerance = is_cheap ? fmin(effort->tolerance, 2e-6) : effort->tolerance,
                            .calls_max = is_cheap || !effort->is_finest ? CHEAP_SWEEPS_MAX : SWEEPS_MAX};
  if (!it.source || (is_column && !it.column)) result = NEPH_ERROR_OUT_OF_MEMORY;
  if (effort->sweeps_plain > 0) {
    for (problem.calls = 0; problem.calls < effort->sweeps_plain && !result; problem.calls++)
      result = map_moments(&it, level->phi, level->phi);
  } else if (!result) {
    result = np_fixed_point_solve(&problem, level->phi);
  }
  effort->residual = problem.residual;
  effort->sweeps = problem.calls;
  np_alloc_free(context, it.column);
  np_alloc_free(context, it.source);
  np_sweep_clear(&it.sweep);
  return result;
}

/* ---- From grid to grid, and to the eye ---- */

void np_transport_level_prolong(const np_transport_level *coarse, np_transport_level *fine) {
  const unsigned count = np_harmonics_count(fine->grid.degree);
  for (size_t live = 0; live < fine->grid.live_count; live++) {
    int32_t near[8];
    float weight[8], *out = fine->phi + live * count;
    const np_dvec3 centre = np_transport_grid_centre(&fine->grid, fine->grid.cell[live]);
    const unsigned found = np_transport_grid_find(&coarse->grid, centre, near, weight);
    for (unsigned i = 0; i < count; i++) out[i] = 0.0f;
    for (unsigned c = 0; c < found; c++)
      for (unsigned i = 0; i < count; i++) out[i] += weight[c] * coarse->phi[(size_t)near[c] * count + i];
  }
}

/* Sunlight in a cell that has gone straight on, weighted by extinction: first collisions over it. */
static float find_straight(const np_transport_level *level, size_t live) {
  const float extinction = level->grid.extinction[live];
  return extinction > 0.0f ? level->sun[live] / extinction : 0.0f;
}

/* The peak that only `broad` counts as straight has, in units of its share of all scattering, the moments 1 up to the
 * degree n + 1 and r_l/r_{n+1} above: nearly all of that light has been scattered by it once. */
void np_transport_level_resolve(const np_transport_lights *lights, const np_transport_level *broad,
                                np_transport_level *fine) {
  const unsigned count = np_harmonics_count(fine->grid.degree), known = np_harmonics_count(broad->grid.degree);
  const unsigned peak = broad->grid.degree + 1;
  for (size_t live = 0; live < fine->grid.live_count; live++) {
    const float *ratio = fine->grid.ratio + live * (fine->grid.degree + 1);
    const float more = fmaxf(0.0f, find_straight(broad, live) - find_straight(fine, live));
    float *phi = fine->phi + live * count;
    for (unsigned l = 0, i = 0; l <= fine->grid.degree; l++) {
      const float share = l <= peak ? 1.0f : ratio[peak] > 0.0f ? np_clampf(ratio[l] / ratio[peak], 0.0f, 1.0f) : 0.0f;
      for (; i < (l + 1) * (l + 1); i++)
        phi[i] = (i < known ? broad->phi[live * known + i] : 0.0f) + share * more * lights->sun_harmonics[i];
    }
  }
}

/* Second differences over an eighth, for even cells; elsewhere φ″ by the parabola through three middles. */
static void sharpen_cell(const np_transport_grid *g, int axis, size_t live, unsigned count, const float *from,
                         float *values) {
  int32_t at[3];
  np_transport_grid_split(g, g->cell[live], at);
  const int32_t below = np_transport_grid_neighbour(g, at, axis, -1),
                above = np_transport_grid_neighbour(g, at, axis, 1);
  if (below < 0 || above < 0) return;
  float down = 0.125f, up = 0.125f;
  if (g->even_m[axis] <= 0.0) {
    const double width = np_transport_grid_width(g, axis, at[axis]);
    const double low = 0.5 * (width + np_transport_grid_width(g, axis, at[axis] - 1));
    const double high = 0.5 * (width + np_transport_grid_width(g, axis, at[axis] + 1));
    down = (float)(0.25 * width * width / (low * (low + high)));
    up = (float)(0.25 * width * width / (high * (low + high)));
  }
  const float *middle = from + live * count;
  for (unsigned i = 0; i < count; i++)
    values[live * count + i] -=
        down * (from[(size_t)below * count + i] - middle[i]) + up * (from[(size_t)above * count + i] - middle[i]);
}

void np_transport_grid_sharpen(const np_transport_grid *grid, unsigned count, float *values, float *scratch) {
  for (int axis = 0; axis < 3; axis++) {
    if (grid->size[axis] == 1) continue;
    memcpy(scratch, values, grid->live_count * count * sizeof *values);
    for (size_t live = 0; live < grid->live_count; live++) sharpen_cell(grid, axis, live, count, scratch, values);
  }
}
