/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering by discrete ordinates in the delta-M scaled medium.
 *
 * Solved for are the real spherical-harmonic moments φ_lm, l ≤ 3, of the radiance of all light but the sun's that went
 * straight on (scaled_phase.c says what that is). With σ′ = Σ k·σ over the clouds, k = 1 − ϖf, and r_l the ratio of the
 * scaled scattering moment Σ ϖσ(χ_l − f) to σ′,
 *
 *     Ω·∇L + σ′L = Σ r_l·(σ′·φ_lm + d·E·Y_lm(s))·Y_lm(Ω),   φ_lm = ∫ L·Y_lm dΩ
 *
 * where d·E is what sunlight of direction s loses by first collisions, and sky and ground enter at the sides. A sweep
 * maps φ to the φ of its solution; Anderson acceleration finds the fixed point, on the coarsest grid first, then from
 * there on finer ones. A band starts from the one before it, in proportion to their sources: where the clouds are grey
 * and the lights of one colour, that is the solution, and costs one sweep.
 */
#include "light/multi_scatter.h"

#include <string.h>

#include "core/alloc.h"
#include "light/fixed_point.h"
#include "light/sweep.h"

enum {
  LEVELS_MAX = 4,
  GROUPS = 4,
  OCTANTS_PER_GROUP = NP_OCTANT_COUNT / GROUPS,
  CHUNK = 4096,
  SWEEPS_MAX = 60,
  CHEAP_SWEEPS_MAX = 200,
  CHEAP_CELLS = 1 << 14, /* live ones, on which a solution costs so little that it is driven to the end of floats */
  DEPTH = 5,
  CHEAP_DEPTH = NP_FIXED_POINT_DEPTH_MAX
};

/* One grid's problem. */
typedef struct level {
  np_transport_grid grid;
  float *sun;  /* of each live cell: first collisions times irradiance, W m⁻³ nm⁻¹, in the present band */
  float *glow; /* of each live cell: the moment l = 0 of what it emits; NULL: nothing glows */
  float *phi;  /* the solution: [live][harmonic] */
} level;

typedef struct solver {
  neph_context *context;
  const np_scene_view *view;
  const np_multi_scatter_desc *desc;
  np_monitor *monitor;
  np_multi_scatter *out;
  np_ordinates *ordinates;
  np_inflow *inflow;
  np_spectrum *sun; /* irradiance at each live cell of the finest grid */
  unsigned level_count, band;
  level levels[LEVELS_MAX];
  float sun_harmonics[NP_HARMONIC_COUNT];
} solver;

/* ---- One sweep ---- */

typedef struct iteration {
  const solver *solver;
  const level *level;
  const float *x;
  float *image;
  float *source;  /* [live][harmonic] */
  float *parts;   /* of each group of octants: [live][harmonic] */
  float *scratch; /* of each group */
  np_sweep sweep;
  np_sweep_fn kernel;
} iteration;

static neph_result fill_source(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const np_transport_grid *g = &it->level->grid;
  for (size_t live = begin; live < end; live++) {
    const float *x = it->x + live * NP_HARMONIC_COUNT;
    float *source = it->source + live * NP_HARMONIC_COUNT;
    for (int i = 0; i < NP_HARMONIC_COUNT; i++)
      source[i] = g->ratio[live][np_harmonic_degree[i]] *
                  (g->extinction[live] * x[i] + it->level->sun[live] * it->solver->sun_harmonics[i]);
    if (it->level->glow) source[0] += it->level->glow[live];
  }
  return NEPH_OK;
}

static neph_result sweep_groups(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const size_t floats = it->level->grid.live_count * NP_HARMONIC_COUNT,
               scratch = np_sweep_count_scratch(&it->level->grid);
  for (size_t group = begin; group < end; group++) {
    float *part = it->parts + group * floats;
    memset(part, 0, floats * sizeof *part);
    for (unsigned n = 0; n < OCTANTS_PER_GROUP; n++)
      it->kernel(&it->sweep, (unsigned)group * OCTANTS_PER_GROUP + n, it->scratch + group * scratch, part);
  }
  return np_monitor_is_cancelled(it->solver->monitor) ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

/* Adds the groups in their order, whoever swept them. */
static neph_result add_parts(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const iteration *it = user;
  const size_t floats = it->level->grid.live_count * NP_HARMONIC_COUNT;
  for (size_t i = begin * NP_HARMONIC_COUNT; i < end * NP_HARMONIC_COUNT; i++) {
    float sum = it->parts[i];
    for (size_t group = 1; group < GROUPS; group++) sum += it->parts[group * floats + i];
    it->image[i] = sum;
  }
  return NEPH_OK;
}

static neph_result map_moments(void *user, const float *x, float *out_image) {
  iteration *it = user;
  const solver *s = it->solver;
  const size_t live = it->level->grid.live_count;
  it->x = x;
  it->image = out_image;
  neph_result result = np_parallel_for(s->context, s->monitor, live, CHUNK, fill_source, it);
  if (!result) result = np_parallel_for(s->context, s->monitor, GROUPS, 1, sweep_groups, it);
  if (!result) result = np_parallel_for(s->context, s->monitor, live, CHUNK, add_parts, it);
  return result;
}

static neph_result solve_level(solver *s, level *l, double tolerance) {
  const size_t floats = l->grid.live_count * NP_HARMONIC_COUNT;
  const size_t wrap = np_sweep_count_wrap(&l->grid);
  iteration it = {.solver = s, .level = l, .kernel = np_sweep_get_kernel(neph_context_get_isa(s->context))};
  it.source = np_alloc(s->context, floats, sizeof *it.source);
  it.parts = np_alloc(s->context, floats, GROUPS * sizeof *it.parts);
  it.scratch = np_alloc(s->context, np_sweep_count_scratch(&l->grid), GROUPS * sizeof *it.scratch);
  float *faces = wrap > 0 ? np_alloc(s->context, wrap, sizeof *faces) : NULL;
  it.sweep = (np_sweep){.grid = &l->grid,
                        .ordinates = s->ordinates,
                        .monitor = s->monitor,
                        .source = it.source,
                        .inflow = (*s->inflow)[s->band],
                        .wrap = faces};
  const bool is_cheap = l->grid.live_count <= CHEAP_CELLS;
  np_fixed_point problem = {.context = s->context,
                            .monitor = s->monitor,
                            .map = map_moments,
                            .user = &it,
                            .count = floats,
                            .depth = is_cheap ? CHEAP_DEPTH : DEPTH,
                            .tolerance = is_cheap ? fmin(tolerance, 2e-6) : tolerance,
                            .calls_max = is_cheap || l != s->levels ? CHEAP_SWEEPS_MAX : SWEEPS_MAX};
  neph_result result = it.source && it.parts && it.scratch && (faces || wrap == 0) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_fixed_point_solve(&problem, l->phi);
  if (l == s->levels) {
    s->out->residual = fmax(s->out->residual, problem.residual);
    s->out->sweeps += problem.calls;
  }
  np_alloc_free(s->context, it.source);
  np_alloc_free(s->context, it.parts);
  np_alloc_free(s->context, it.scratch);
  np_alloc_free(s->context, faces);
  return result;
}

/* ---- From grid to grid ---- */

/* What a finer grid starts from: the coarser solution between the middles of its cells. */
static void prolong(const level *coarse, level *fine) {
  for (size_t live = 0; live < fine->grid.live_count; live++) {
    int32_t near[8];
    float weight[8], *out = fine->phi + live * NP_HARMONIC_COUNT;
    const np_dvec3 centre = np_transport_grid_centre(&fine->grid, fine->grid.cell[live]);
    const unsigned count = np_transport_grid_find(&coarse->grid, centre, near, weight);
    for (int i = 0; i < NP_HARMONIC_COUNT; i++) out[i] = 0.0f;
    for (unsigned c = 0; c < count; c++)
      for (int i = 0; i < NP_HARMONIC_COUNT; i++)
        out[i] += weight[c] * coarse->phi[(size_t)near[c] * NP_HARMONIC_COUNT + (size_t)i];
  }
}

static neph_result solve_nested(solver *s) {
  for (unsigned n = s->level_count; n-- > 0;) {
    level *l = &s->levels[n];
    if (n + 1 < s->level_count) prolong(&s->levels[n + 1], l);
    /* What crosses a thick cloud slowly, and shows late in the residual, is found on coarse cells: they are cheap. */
    neph_result result = solve_level(s, l, n > 0 ? 0.03 * s->desc->tolerance : s->desc->tolerance);
    if (result) return result;
  }
  return NEPH_OK;
}

/* Live neighbour along an axis, or NP_TRANSPORT_CELL_NONE. */
static int32_t find_neighbour(const np_transport_grid *g, int32_t cell, int axis, int step) {
  const int32_t stride[3] = {1, g->size[0], g->size[0] * g->size[1]};
  const int32_t at = cell / stride[axis] % g->size[axis];
  int32_t next = at + step;
  if (g->is_wrapped[axis]) next = (next + g->size[axis]) % g->size[axis];
  return next < 0 || next >= g->size[axis] ? NP_TRANSPORT_CELL_NONE : g->live[cell + (next - at) * stride[axis]];
}

/* A sweep gives means over cells, and interpolating between those is low by edge²/8 of the second derivative, per axis:
 * φ − δ²φ/8 has values that interpolate to the right curve. `scratch` takes a copy. */
static void sharpen(const np_transport_grid *g, float *phi, float *scratch) {
  for (int axis = 0; axis < 3; axis++) {
    if (g->size[axis] == 1) continue;
    memcpy(scratch, phi, g->live_count * NP_HARMONIC_COUNT * sizeof *phi);
    for (size_t live = 0; live < g->live_count; live++) {
      const int32_t below = find_neighbour(g, g->cell[live], axis, -1),
                    above = find_neighbour(g, g->cell[live], axis, 1);
      if (below < 0 || above < 0) continue;
      for (size_t i = 0; i < NP_HARMONIC_COUNT; i++)
        phi[live * NP_HARMONIC_COUNT + i] -=
            0.125f * (scratch[(size_t)below * NP_HARMONIC_COUNT + i] - 2.0f * scratch[live * NP_HARMONIC_COUNT + i] +
                      scratch[(size_t)above * NP_HARMONIC_COUNT + i]);
    }
  }
}

/* ---- Bands ---- */

static void clear_levels(solver *s, unsigned first) {
  for (unsigned n = first; n < s->level_count; n++) {
    level *l = &s->levels[n];
    np_alloc_free(s->context, l->sun);
    np_alloc_free(s->context, l->glow);
    np_alloc_free(s->context, l->phi);
    np_transport_grid_clear(&l->grid);
    *l = (level){0};
  }
  s->level_count = 0;
}

static neph_result allocate_level(solver *s, level *l) {
  l->sun = np_alloc(s->context, l->grid.live_count, sizeof *l->sun);
  l->phi = np_alloc(s->context, l->grid.live_count, NP_HARMONIC_COUNT * sizeof *l->phi);
  if (!l->sun || !l->phi) return NEPH_ERROR_OUT_OF_MEMORY;
  if (s->view->emission) l->glow = np_alloc(s->context, l->grid.live_count, sizeof *l->glow);
  return l->glow || !s->view->emission ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* The grids for the present band's albedo. */
static neph_result build_levels(solver *s) {
  clear_levels(s, 0);
  level *finest = &s->levels[s->level_count++];
  finest->grid.context = s->context;
  np_transport_grid_place(s->view, &s->desc->cells, &finest->grid);
  const np_scaled_phase *phases = s->out->phases;
  np_monitor_set_stage(s->monitor, "averaging clouds");
  neph_result result = np_transport_grid_fill(s->view, phases, s->band, s->monitor, &finest->grid);
  np_monitor_set_stage(s->monitor, "lighting clouds");
  if (!result) result = np_transport_grid_light(s->view, phases, s->band, s->monitor, &finest->grid);
  if (!result) result = allocate_level(s, finest);
  while (!result && s->level_count < LEVELS_MAX) {
    const np_transport_grid *fine = &s->levels[s->level_count - 1].grid;
    if (!np_transport_grid_can_coarsen(fine)) break;
    level *l = &s->levels[s->level_count++];
    result = np_transport_grid_coarsen(fine, &l->grid);
    if (!result) result = allocate_level(s, l);
  }
  return result;
}

static neph_result find_sun(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const solver *s = user;
  const np_transport_grid *g = &s->levels[0].grid;
  for (size_t live = begin; live < end; live++)
    if (g->deposit && g->deposit[live] > 0.0f)
      s->sun[live] = np_light_sun(s->view, np_transport_grid_centre(g, g->cell[live]), s->view->to_sun);
  return NEPH_OK;
}

/* What glows in a cell is even, and has the moment j·∫Y₀₀ dΩ = j·√(4π). */
static neph_result average_glow(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const solver *s = user;
  const level *finest = &s->levels[0];
  const int32_t *size = finest->grid.size;
  if (np_monitor_is_cancelled(s->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t live = begin; live < end; live++) {
    const int32_t c = finest->grid.cell[live], cell[3] = {c % size[0], c / size[0] % size[1], c / size[0] / size[1]};
    finest->glow[live] =
        sqrtf(4.0f * NP_PI_F) * np_transport_grid_average_emission(&finest->grid, s->view->emission, cell, s->band);
  }
  return NEPH_OK;
}

static neph_result fill_glow(solver *s) {
  if (!s->view->emission) return NEPH_OK;
  neph_result result = np_parallel_for(s->context, s->monitor, s->levels[0].grid.live_count, 256, average_glow, s);
  for (unsigned n = 1; n < s->level_count && !result; n++)
    np_transport_grid_restrict(&s->levels[n - 1].grid, s->levels[n - 1].glow, 1, &s->levels[n].grid, s->levels[n].glow);
  return result;
}

/* Fills the levels' sources for the present band; returns their sum, with what flows in. */
static double light_levels(solver *s) {
  level *finest = &s->levels[0];
  double sum = 0.0;
  for (size_t live = 0; live < finest->grid.live_count; live++) {
    finest->sun[live] = finest->grid.deposit ? finest->grid.deposit[live] * s->sun[live].band[s->band] : 0.0f;
    sum += (double)finest->sun[live] + (finest->glow ? (double)finest->glow[live] : 0.0);
  }
  for (unsigned n = 1; n < s->level_count; n++)
    np_transport_grid_restrict(&s->levels[n - 1].grid, s->levels[n - 1].sun, 1, &s->levels[n].grid, s->levels[n].sun);
  const float *inflow = &(*s->inflow)[s->band][0][0][0];
  for (size_t i = 0; i < sizeof **s->inflow / sizeof(float); i++) sum += (double)inflow[i];
  return sum;
}

static bool is_grey(const np_scene_view *view) {
  for (unsigned v = 0; v < view->volume_count; v++)
    for (int b = 1; b < NP_BAND_COUNT; b++)
      if (view->volumes[v].albedo.band[b] != view->volumes[v].albedo.band[0]) return false;
  return true;
}

/* The start of a further band of grey clouds. */
static void scale_solution(solver *s, double factor) {
  level *finest = &s->levels[0];
  for (size_t i = 0; i < finest->grid.live_count * NP_HARMONIC_COUNT; i++) finest->phi[i] *= (float)factor;
}

static neph_result keep_band(solver *s, float *scratch) {
  const level *finest = &s->levels[0];
  const size_t floats = finest->grid.live_count * NP_HARMONIC_COUNT;
  float *sharp = scratch + floats;
  memcpy(sharp, finest->phi, floats * sizeof *sharp);
  sharpen(&finest->grid, sharp, scratch);
  for (size_t live = 0; live < finest->grid.live_count; live++)
    memcpy(s->out->moments[live].band[s->band], sharp + live * NP_HARMONIC_COUNT, NP_HARMONIC_COUNT * sizeof *sharp);
  return NEPH_OK;
}

static neph_result solve_band(solver *s, bool is_first, double *sum) {
  const double before = *sum;
  neph_result result = fill_glow(s);
  if (result) return result;
  *sum = light_levels(s);
  if (*sum <= 0.0) return NEPH_OK;
  np_monitor_set_stage(s->monitor, "solving multiple scattering");
  if (is_first || !(before > 0.0)) {
    result = solve_nested(s);
  } else {
    scale_solution(s, *sum / before);
    result = solve_level(s, &s->levels[0], s->desc->tolerance);
  }
  if (result) return result;
  const size_t floats = s->levels[0].grid.live_count * NP_HARMONIC_COUNT;
  float *scratch = np_alloc(s->context, floats, 2 * sizeof *scratch);
  if (!scratch) return NEPH_ERROR_OUT_OF_MEMORY;
  result = keep_band(s, scratch);
  np_alloc_free(s->context, scratch);
  return result;
}

static neph_result solve_bands(solver *s) {
  const bool has_one_grid = is_grey(s->view);
  double sum = 0.0;
  for (s->band = 0; s->band < NP_BAND_COUNT; s->band++) {
    const bool is_first = s->band == 0 || !has_one_grid;
    neph_result result = is_first ? build_levels(s) : NEPH_OK;
    if (!result && s->band == 0) {
      const size_t live = s->levels[0].grid.live_count;
      s->sun = np_alloc(s->context, live, sizeof *s->sun);
      s->out->moments = np_alloc(s->context, live, sizeof *s->out->moments);
      result = s->sun && s->out->moments ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
      if (!result) result = np_parallel_for(s->context, s->monitor, live, CHUNK, find_sun, s);
    }
    if (!result) result = solve_band(s, is_first, &sum);
    if (result) return result;
  }
  return NEPH_OK;
}

/* ---- All of it ---- */

static bool is_same_lobe(np_phase_lobe a, np_phase_lobe b) { return a.asymmetry == b.asymmetry && a.alpha == b.alpha; }

static bool is_same_phase(const np_phase *a, const np_phase *b) {
  return is_same_lobe(a->lobe[0], b->lobe[0]) && is_same_lobe(a->lobe[1], b->lobe[1]) && a->weight == b->weight &&
         a->table == b->table && a->table_weight == b->table_weight;
}

/* Equal phase functions share one table. */
static neph_result build_phases(const np_scene_view *view, np_multi_scatter *out) {
  out->phases = np_alloc(out->context, view->volume_count, sizeof *out->phases);
  if (!out->phases) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned v = 0; v < view->volume_count; v++) {
    const np_phase *phase = &view->volumes[v].phase;
    unsigned same = 0;
    while (same < v && !is_same_phase(&out->phases[same].phase, phase)) same++;
    if (same < v) {
      out->phases[v] = out->phases[same];
    } else {
      neph_result result = np_scaled_phase_init(out->context, phase, &out->phases[v]);
      if (result) return result;
    }
    out->volume_count = v + 1;
  }
  return NEPH_OK;
}

/* In a layer without end much light runs along it, for which level-symmetric sets are too coarse. */
static unsigned choose_order(const solver *s) {
  np_transport_grid grid;
  np_transport_grid_place(s->view, &s->desc->cells, &grid);
  return grid.is_wrapped[0] || grid.is_wrapped[1] ? NP_ORDINATES_PRODUCT : s->desc->order;
}

static void start_inflow(solver *s) {
  np_ordinates_init(choose_order(s), s->ordinates);
  np_inflow_fill(s->view, &s->desc->cells, s->ordinates, *s->inflow);
  np_harmonics_eval(np_vec3_scale(s->view->to_sun, -1.0f), s->sun_harmonics);
}

neph_result np_multi_scatter_build(neph_context *context, const np_scene_view *view, const np_multi_scatter_desc *desc,
                                   np_monitor *monitor, np_multi_scatter *out) {
  *out = (np_multi_scatter){.context = context};
  solver s = {.context = context, .view = view, .desc = desc, .monitor = monitor, .out = out};
  s.ordinates = np_alloc(context, 1, sizeof *s.ordinates);
  s.inflow = np_alloc(context, 1, sizeof *s.inflow);
  neph_result result = s.ordinates && s.inflow ? build_phases(view, out) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) start_inflow(&s);
  if (!result) result = solve_bands(&s);
  if (!result) {
    out->grid = s.levels[0].grid;
    s.levels[0].grid = (np_transport_grid){0};
    np_log(context, NEPH_LOG_DEBUG,
           "multiple scattering: %d x %d x %d cells of %.4g m, %zu in cloud, residual %.2g after %u sweeps",
           out->grid.size[0], out->grid.size[1], out->grid.size[2], out->grid.cell_m[0], out->grid.live_count,
           out->residual, out->sweeps);
    if (out->residual > 10.0 * desc->tolerance)
      np_log(context, NEPH_LOG_WARNING, "multiple scattering has not converged: residual %.2g, wanted %.2g",
             out->residual, desc->tolerance);
  }
  clear_levels(&s, 0);
  np_alloc_free(context, s.sun);
  np_alloc_free(context, s.inflow);
  np_alloc_free(context, s.ordinates);
  if (result) np_multi_scatter_clear(out);
  return result;
}

void np_multi_scatter_clear(np_multi_scatter *scatter) {
  for (unsigned v = 0; v < scatter->volume_count; v++) {
    bool is_shared = false;
    for (unsigned u = 0; u < v; u++) is_shared = is_shared || scatter->phases[u].peak == scatter->phases[v].peak;
    if (!is_shared) np_alloc_free(scatter->context, scatter->phases[v].peak);
  }
  np_alloc_free(scatter->context, scatter->phases);
  np_transport_grid_clear(&scatter->grid);
  np_alloc_free(scatter->context, scatter->moments);
  *scatter = (np_multi_scatter){0};
}
