/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering by discrete ordinates in the delta-M scaled medium.
 *
 * Solved for are the real spherical-harmonic moments φ_lm, l ≤ N, of the radiance of all light but the sun's that went
 * straight on (scaled_phase.c says what that is). With σ′ = Σ k·σ over the clouds, k = 1 − ϖf, and r_l the ratio of the
 * scaled scattering moment Σ ϖσ(χ_l − f) to σ′,
 *
 *     Ω·∇L + σ′L = Σ r_l·(σ′·φ_lm + d·E·Y_lm(s))·Y_lm(Ω),   φ_lm = ∫ L·Y_lm dΩ
 *
 * where d·E is what sunlight of direction s loses by first collisions, and sky and ground enter at the sides. A sweep
 * maps φ to the φ of its solution, and a diffusion equation adds what it leaves out in thick clouds
 * (diffusion_correction.c); Anderson acceleration finds the fixed point, on the coarsest grid first, then from there on
 * finer ones.
 *
 * Small clouds are solved to a high degree from the start. Larger ones get the least degree, and where the memory
 * allows it that solution is then resolved into more: a high degree counts less of the sun's light as having gone
 * straight on, the rest is in φ, and from there on sweeps do but what is local, which they do well. So is what large
 * pictures show within cells: fine ones, half as wide, start from there and are swept in the same way.
 *
 * Where the clouds are grey bands differ in their light alone. A further band starts from those before it, in
 * proportion to their sources, on every grid; the coarsest is solved first, and what that changes is added to the start
 * of the next finer. So cells carry between grids no more than the difference of two bands, which is smooth and small,
 * and the finest grid is left with half of the sweeps. Where the lights have one colour, the first band is the solution
 * of all.
 */
#include "transport/scattering_solver.h"

#include <string.h>

#include "core/alloc.h"
#include "transport/reused_cells.h"

enum { CHUNK = 1024, MOMENTS = 16 * CHUNK };

static bool is_fine(const np_scattering_solver *s) { return s->levels[0].grid.is_fine; }
static bool is_resolved(const np_scattering_solver *s) { return s->fine != s->broad; }

/* Least determinant of the fit of a band by two others, relative to the sum of its products: two bands of the same
 * colour cannot fit a third. */
static const double blend_least = 0.02;

/* ---- Time and progress ---- */

/* Fractions of a band's work at which sweeps begin and the last ones begin. */
static const double solving_begin = 0.15, resolving_begin = 0.85, keeping_begin = 0.95;

/* Sets the next steps to be [begin, end] of the band's work. */
static void set_part(const np_scattering_solver *s, double begin, double end) {
  const double count = s->out->medium.band_count;
  np_monitor_set_part(s->monitor, s->whole, (s->turn + begin) / count, (s->turn + end) / count);
}

/* A level takes time as it has cells. */
static void set_level_part(const np_scattering_solver *s, unsigned number) {
  double all = 0.0, before = 0.0;
  for (unsigned n = np_scattering_solver_get_iterated(s); n < s->level_count; n++) {
    all += (double)s->levels[n].grid.active_count;
    if (n > number) before += (double)s->levels[n].grid.active_count;
  }
  const double per_cell = (resolving_begin - solving_begin) / fmax(all, 1.0), begin = solving_begin + per_cell * before;
  set_part(s, begin, begin + per_cell * (double)s->levels[number].grid.active_count);
}

/* Records that time ran out for the present band. */
static void note_cut(np_scattering_solver *s) {
  const unsigned width = 1u << (s->reached.level - np_scattering_solver_get_iterated(s));
  s->has_time = false;
  s->cut = s->reached;
  s->out->quality.is_cut = true;
  s->out->quality.residual = fmax(s->out->quality.residual, s->reached.residual);
  s->out->quality.cut_width = width > s->out->quality.cut_width ? width : s->out->quality.cut_width;
}

/* Begins the band's share of the remaining time. Bands before the last get a little less, so that the last reaches the
 * level at which the first was cut. */
static void begin_budget(np_scattering_solver *s) {
  const unsigned bands_left = s->out->medium.band_count - s->turn;
  s->has_time = true;
  if (s->is_nested) s->reached = (np_scattering_reach){.level = s->level_count, .residual = 1.0};
  if (!isfinite(s->end_s)) return;
  const double now_s = np_monitor_get_seconds(s->monitor), share = (bands_left > 1 ? 0.9 : 1.0) / bands_left;
  if (now_s < s->end_s)
    np_monitor_begin_budget(s->monitor, now_s + share * (s->end_s - now_s));
  else
    note_cut(s);
}

static void end_budget(np_scattering_solver *s) {
  if (np_monitor_end_budget(s->monitor)) note_cut(s);
}

/* ---- Levels ---- */

/* Light that leaves the clouds towards ground and air, in all. */
static double sum_outflow(const np_outflow *outflow) {
  const float *way = &outflow->way[0][0][0];
  double sum = 0.0;
  for (int i = 0; i < NP_BORDER_WAYS * NP_BORDER_PLAN * NP_BORDER_PLAN; i++) sum += fabs((double)way[i]);
  return sum;
}

/* Whether ground and air return enough of what leaves the clouds that the finest level is solved again under what it
 * lets out itself: coarser cells of a deep deck let out more. */
static bool is_returned(const np_scattering_solver *s) {
  static const double least = 0.02; /* share of all light that is returned */
  if (s->levels[np_scattering_solver_get_iterated(s)].ground) return true;
  const double returned = np_border_sum_change(&s->broad->border, s->band, &s->broad->ordinates);
  return s->has_outflow && returned > least * (s->sources + returned);
}

static bool is_within(double a, double b, double ratio) { return a <= ratio * b && b <= ratio * a; }

/* Moves an outflow on beyond what a solution under `before` lets out: the rest follows in ever smaller steps. */
static void exaggerate(const np_outflow *before, np_outflow *outflow) {
  static const float step = 1.5f;
  const float *from = &before->way[0][0][0];
  float *to = &outflow->way[0][0][0];
  for (int i = 0; i < NP_BORDER_WAYS * NP_BORDER_PLAN * NP_BORDER_PLAN; i++)
    to[i] = fmaxf(from[i] + step * (to[i] - from[i]), 0.0f);
}

/* Solves a level, and lights its border by what it lets out. A coarse solution of deep clouds may be far from the
 * level's: where it let out more than twice the light, or less than half, the level is solved under none, and again
 * until what it lets out agrees with what it is under to 2 %, on the finest level to 0.2 %. */
static neph_result solve_under_outflow(np_scattering_solver *s, np_transport_level *level,
                                       np_transport_effort *effort) {
  enum { TURNS_MAX = 16 };
  static const double far_ratio = 2.0, near_ratio = 1.02, finest_ratio = 1.002;
  const bool is_lit = effort->outflow && s->has_outflow;
  double ratio = effort->is_finest ? finest_ratio : far_ratio;
  unsigned sweeps = 0;
  for (int turn = 0; turn < TURNS_MAX; turn++) {
    np_outflow before = {{{{0}}}};
    if (effort->outflow && s->has_outflow) before = *effort->outflow;
    neph_result result = np_transport_level_solve(&s->broad->lights, level, effort);
    effort->sweeps = sweeps += effort->sweeps;
    if (result || !effort->outflow || effort->is_cut || effort->sweeps == 0) return result;
    const double after = sum_outflow(effort->outflow), under = sum_outflow(&before);
    const bool is_done = !is_lit || is_within(after, under, ratio);
    s->has_outflow = is_done || turn > 0 || is_within(after, under, far_ratio);
    if (!is_done && s->has_outflow && under > 0.0) exaggerate(&before, effort->outflow);
    np_scattering_solver_light_border(s);
    if (is_done) break;
    ratio = effort->is_finest ? finest_ratio : near_ratio;
  }
  return NEPH_OK;
}

/* Solves a level. A band goes no further than the band that was cut before, or clouds would get its colour. Coarse
 * levels provide the light that clouds send down, for the border of finer levels. */
static neph_result solve_level(np_scattering_solver *s, unsigned number, double tolerance) {
  if (!np_solver_state_begin(s, NP_STEP_FRAGILE)) return NEPH_OK;
  if (s->out->quality.is_cut && number < s->cut.level) return NEPH_OK;
  np_transport_level *level = &s->levels[number];
  const np_fixed_point_keeper keeper = {s, np_solver_state_load_history, np_solver_state_save_history};
  np_transport_effort effort = {.tolerance = tolerance,
                                .is_finest = number == np_scattering_solver_get_iterated(s),
                                .keeper = s->state.keeper ? &keeper : NULL};
  if (effort.is_finest && s->is_nested) s->is_returned = is_returned(s);
  if (!effort.is_finest || number + 1 == s->level_count || s->is_returned) effort.outflow = &s->outflow[s->band];
  if (s->out->quality.is_cut && number == s->cut.level) effort.sweeps_max = s->cut.sweeps;
  set_level_part(s, number);
  neph_result result = solve_under_outflow(s, level, &effort);
  if (effort.sweeps > 0 && (s->is_nested || effort.is_finest))
    s->reached = (np_scattering_reach){number, effort.is_cut ? effort.sweeps : 0, effort.residual};
  if (effort.is_cut) end_budget(s);
  if (!effort.is_finest || effort.is_cut) return result;
  s->out->quality.residual = fmax(s->out->quality.residual, effort.residual);
  s->out->sweeps += effort.sweeps;
  return result;
}

/* Interpolates the start of a level from the next coarser one, even if time has run out: it costs little, and the level
 * would be zero. */
static neph_result prolong(np_scattering_solver *s, unsigned number, np_step_kind kind) {
  if (!np_solver_state_begin(s, kind)) return NEPH_OK;
  neph_result result = np_transport_level_prolong(&s->levels[number + 1], s->monitor, &s->levels[number]);
  if (result != NEPH_ERROR_CANCELLED || !np_monitor_is_cut(s->monitor)) return result;
  end_budget(s);
  return np_transport_level_prolong(&s->levels[number + 1], s->monitor, &s->levels[number]);
}

static neph_result solve_nested(np_scattering_solver *s) {
  const unsigned finest = np_scattering_solver_get_iterated(s);
  neph_result result = NEPH_OK;
  for (unsigned n = s->level_count; n-- > finest && !result;) {
    if (n + 1 < s->level_count) result = prolong(s, n, NP_STEP_RESTARTABLE);
    if (result || !s->has_time) continue;
    result = solve_level(s, n, n > finest ? 3.0 * s->desc->tolerance : s->desc->tolerance);
    if (!result && s->has_time && s->level_count == finest + 1) result = solve_level(s, n, s->desc->tolerance);
  }
  return result;
}

/* Sweeps as long as there is time. */
static neph_result sweep_level(np_scattering_solver *s, unsigned number, unsigned sweeps) {
  neph_result result = NEPH_OK;
  for (unsigned n = 0; n < sweeps && s->has_time && !s->out->quality.is_cut && !result; n++) {
    np_monitor_set_range(s->monitor, (double)n / sweeps, (double)n / sweeps);
    if (!np_solver_state_begin(s, NP_STEP_WITHIN)) continue;
    result = np_transport_level_sweep(&s->fine->lights, &s->levels[number], isfinite(s->end_s));
    if (np_monitor_is_cut(s->monitor)) end_budget(s);
  }
  return result;
}

/* Extends the iterated solution to the result's degree and to its fine cells, by a few sweeps each. */
static neph_result resolve(np_scattering_solver *s) {
  const unsigned iterated = np_scattering_solver_get_iterated(s);
  neph_result result = NEPH_OK;
  set_part(s, resolving_begin, is_fine(s) ? 0.5 * (resolving_begin + keeping_begin) : keeping_begin);
  const bool is_new = np_solver_state_begin(s, NP_STEP_RESTARTABLE);
  s->state.has_fine = true;
  np_workspace_clear(&s->workspace); /* sweeps take less than iterations */
  if (is_resolved(s)) {
    if (is_new) result = np_transport_level_resolve(&s->fine->lights, &s->levels[iterated], &s->levels[iterated - 1]);
    if (!result) result = sweep_level(s, iterated - 1, NP_RESOLVING_SWEEPS);
  }
  if (!is_fine(s) || result) return result;
  set_part(s, 0.5 * (resolving_begin + keeping_begin), keeping_begin);
  result = prolong(s, 0, NP_STEP_WITHIN);
  return result ? result : sweep_level(s, 0, NP_REFINING_SWEEPS);
}

/* ---- Bands ---- */

void np_scattering_solver_clear_levels(np_scattering_solver *s) {
  for (unsigned n = 0; n < s->level_count; n++) np_transport_level_clear(&s->levels[n]);
  s->level_count = 0;
}

static neph_result add_coarser(np_scattering_solver *s) {
  const np_transport_grid *fine = &s->levels[s->level_count - 1].grid;
  return np_transport_grid_coarsen(fine, &s->levels[s->level_count++].grid);
}

static neph_result add_broad(np_scattering_solver *s) {
  const np_transport_grid *fine = &s->levels[s->level_count - 1].grid;
  np_transport_grid *broad = &s->levels[s->level_count++].grid;
  return np_transport_grid_reduce_degree(s->world, s->band, s->broad->ordinates.degree, fine, broad);
}

neph_result np_scattering_solver_build_levels(np_scattering_solver *s) {
  np_scattering_solver_clear_levels(s);
  np_transport_grid *finest = &s->levels[s->level_count++].grid;
  bool is_lit;
  neph_result result = np_transport_grid_place(s->context, s->world, &s->desc->cells, finest);
  if (result) return result;
  finest->degree = s->fine->ordinates.degree;
  set_part(s, 0.0, 0.05);
  np_monitor_set_stage(s->monitor, "averaging clouds");
  if (!np_reused_cells_move(s->desc->reused, finest, &is_lit))
    result = np_transport_grid_fill(s->world, s->phases, s->band, s->monitor, finest);
  set_part(s, 0.05, solving_begin);
  np_monitor_set_stage(s->monitor, "lighting clouds");
  np_ground_columns_clear(s->context, &s->ground);
  if (!result) result = np_ground_columns_fill(finest, s->world, s->depths, s->fade, s->monitor, &s->ground);
  if (!result && !is_lit)
    result = np_transport_grid_light(s->world, s->depths, s->monitor, s->band, s->broad->ordinates.degree, finest);
  if (!result && is_fine(s)) result = add_coarser(s);
  if (!result && is_resolved(s)) result = add_broad(s);
  while (!result && s->level_count < NP_SCATTERING_LEVELS_MAX &&
         np_transport_grid_can_coarsen(&s->levels[s->level_count - 1].grid))
    result = add_coarser(s);
  for (unsigned n = 0; n < s->level_count && !result; n++)
    result = np_transport_level_allocate(&s->levels[n], s->world->emission);
  for (unsigned n = 0; n < s->level_count && !result; n++)
    if (is_resolved(s) && n == np_scattering_solver_get_iterated(s))
      s->levels[n].air = np_cell_air_borrow(&s->levels[n - 1].air);
    else
      result = np_cell_air_fill(&s->levels[n].grid, s->world, s->depths, s->fade, s->monitor, &s->levels[n].air);
  return result;
}

/* Emission in a cell is even, and has the moment j·∫Y₀₀ dΩ = j·√(4π). */
static neph_result average_emission(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_scattering_solver *s = user;
  const np_transport_level *finest = &s->levels[0];
  if (np_monitor_is_cancelled(s->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t active = begin; active < end; active++) {
    int32_t at[3];
    np_transport_grid_split(&finest->grid, finest->grid.cell[active], at);
    finest->emission[active] =
        sqrtf(4.0f * NP_PI_F) * np_transport_grid_average_emission(&finest->grid, s->world->emission, at, s->band);
  }
  return NEPH_OK;
}

/* Averages a quantity of one level's cells over the cells of the next coarser level `to`. */
static void restrict_level(const np_scattering_solver *s, unsigned to, const float *from, float *out) {
  const np_transport_grid *fine = &s->levels[to - 1].grid, *coarse = &s->levels[to].grid;
  if (is_resolved(s) && to == np_scattering_solver_get_iterated(s)) {
    memcpy(out, from, fine->active_count * sizeof *out);
  } else {
    np_transport_grid_restrict(fine, from, coarse, out);
  }
}

static neph_result fill_emission(np_scattering_solver *s) {
  if (!s->world->emission) return NEPH_OK;
  neph_result result =
      np_parallel_for(s->context, s->monitor, s->levels[0].grid.active_count, 256, average_emission, s);
  for (unsigned n = 1; n < s->level_count && !result; n++)
    restrict_level(s, n, s->levels[n - 1].emission, s->levels[n].emission);
  return result;
}

typedef struct sunlight_job {
  const np_scattering_solver *solver;
  const float *first_collision_source; /* NULL: none */
  float *out;
} sunlight_job;

static neph_result multiply_sun(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const sunlight_job *job = user;
  const np_scattering_solver *s = job->solver;
  const float *source = job->first_collision_source;
  for (size_t active = begin; active < end; active++)
    job->out[active] = source ? source[active] * s->sun[active].band[s->band] : 0.0f;
  return NEPH_OK;
}

/* First collisions times irradiance, of the finest cells. */
static void light_cells(const np_scattering_solver *s, const float *first_collision_source, float *out) {
  sunlight_job job = {s, first_collision_source, out};
  (void)np_parallel_for(s->context, NULL, s->levels[0].grid.active_count, CHUNK, multiply_sun, &job);
}

/* Fills the first collisions in the iterated medium, where the result has another. */
static neph_result light_broad(const np_scattering_solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  float *broad = s->levels[np_scattering_solver_get_iterated(s)].sun;
  if (!is_fine(s)) {
    light_cells(s, g->low_order_source, broad);
    return NEPH_OK;
  }
  float *own = np_alloc(s->context, g->active_count, sizeof *own);
  if (!own) return NEPH_ERROR_OUT_OF_MEMORY;
  light_cells(s, g->low_order_source, own);
  np_transport_grid_restrict(g, own, &s->levels[1].grid, broad);
  np_alloc_free(s->context, own);
  return NEPH_OK;
}

/* Fills the levels' sources for the present band, and their sum with the light that enters the box. */
static neph_result light_levels(np_scattering_solver *s, double *out_sum) {
  const unsigned iterated = np_scattering_solver_get_iterated(s);
  light_cells(s, s->levels[0].grid.first_collision_source, s->levels[0].sun);
  if (is_fine(s)) restrict_level(s, 1, s->levels[0].sun, s->levels[1].sun);
  neph_result result = is_resolved(s) ? light_broad(s) : NEPH_OK;
  if (result) return result;
  for (unsigned n = iterated + 1; n < s->level_count; n++) restrict_level(s, n, s->levels[n - 1].sun, s->levels[n].sun);
  s->fine->lights.border = &s->fine->border.faces[s->band];
  s->broad->lights.border = &s->broad->border.faces[s->band];
  s->has_outflow = false;
  np_scattering_solver_light_border(s);

  const np_transport_level *level = &s->levels[iterated];
  *out_sum = 0.0;
  for (size_t active = 0; active < level->grid.active_count; active++)
    *out_sum += (double)level->sun[active] + (level->emission ? (double)level->emission[active] : 0.0) +
                (level->air.sunlit ? (double)np_transport_level_get_air(level, active) : 0.0);
  const np_ordinates *o = &s->broad->ordinates;
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned i = 0; i < o->count; i++)
      *out_sum += np_border_get_mean(&s->broad->border, s->band, octant, i / NP_ORDINATE_LANES, i % NP_ORDINATE_LANES);
  s->sources = *out_sum;
  return NEPH_OK;
}

/* Factors on the solutions of the first band and of the last. */
typedef struct blend {
  double first, last;
} blend;

/* The blend of two bands that has as much sunlight as a third, and as much light from around. */
static bool compute_blend(const np_scattering_solver *s, blend *out) {
  const unsigned first = np_scattering_band_order[0], last = np_scattering_band_order[1];
  const double *sun = s->sunlight, *around = s->surroundings;
  const double first_last = sun[first] * around[last], last_first = sun[last] * around[first];
  const double determinant = first_last - last_first;
  if (s->turn < 2 || !s->is_related || s->world->emission) return false;
  if (!(fabs(determinant) > blend_least * (first_last + last_first))) return false;
  out->first = (sun[s->band] * around[last] - sun[last] * around[s->band]) / determinant;
  out->last = (sun[first] * around[s->band] - sun[s->band] * around[first]) / determinant;
  return true;
}

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

typedef struct blend_job {
  const blend *blend;
  bool has_first;
  const np_transport_level *level;
} blend_job;

static neph_result blend_moments(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const blend_job *job = user;
  float *phi = job->level->phi;
  for (size_t i = begin; i < end; i++) {
    phi[i] *= (float)job->blend->last;
    if (job->has_first) phi[i] += (float)job->blend->first * job->level->first_phi[i];
  }
  return NEPH_OK;
}

/* The start of a further band, on all grids: at least in proportion to the sources, by `factor`. */
static void blend_solution(np_scattering_solver *s, double factor) {
  blend b = {0.0, factor};
  const bool has_both = compute_blend(s, &b);
  const float *first = &s->outflow[np_scattering_band_order[0]].way[0][0][0];
  const float *last = &s->outflow[np_scattering_band_order[s->turn - 1]].way[0][0][0];
  float *own = &s->outflow[s->band].way[0][0][0];
  for (int i = 0; i < NP_BORDER_WAYS * NP_BORDER_PLAN * NP_BORDER_PLAN; i++)
    own[i] = (float)b.last * last[i] + (has_both ? (float)b.first * first[i] : 0.0f);
  s->has_outflow = true;
  np_scattering_solver_light_border(s);
  for (unsigned n = np_scattering_solver_get_iterated(s); n < s->level_count; n++) {
    blend_job job = {&b, has_both, &s->levels[n]};
    (void)np_parallel_for(s->context, NULL, count_moments(&s->levels[n].grid), MOMENTS, blend_moments, &job);
  }
}

static neph_result copy_first(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_transport_level *l = user;
  memcpy(l->first_phi + begin, l->phi + begin, (end - begin) * sizeof *l->first_phi);
  return NEPH_OK;
}

void np_scattering_solver_keep_first(np_scattering_solver *s) {
  for (unsigned n = np_scattering_solver_get_iterated(s); n < s->level_count; n++) {
    np_transport_level *l = &s->levels[n];
    if (l->first_phi) (void)np_parallel_for(s->context, NULL, count_moments(&l->grid), MOMENTS, copy_first, l);
  }
}

static neph_result copy_start(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_transport_level *l = user;
  memcpy(l->change + begin, l->phi + begin, (end - begin) * sizeof *l->change);
  return NEPH_OK;
}

static neph_result subtract_start(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_transport_level *l = user;
  for (size_t i = begin; i < end; i++) l->change[i] = l->phi[i] - l->change[i];
  return NEPH_OK;
}

/* Solves a level for a further band. `change` becomes the difference between the solution and its start. */
static neph_result change_level(np_scattering_solver *s, unsigned number) {
  np_transport_level *l = &s->levels[number];
  const size_t count = l->change ? count_moments(&l->grid) : 0;
  neph_result result = NEPH_OK;
  if (np_solver_state_begin(s, NP_STEP_FRAGILE)) {
    if (l->change) (void)np_parallel_for(s->context, NULL, count, MOMENTS, copy_start, l);
    if (number + 1 < s->level_count) result = np_transport_level_prolong_change(l + 1, l);
  }
  if (!result && s->has_time) result = solve_level(s, number, s->desc->tolerance);
  if (!result && s->has_time && s->level_count == 1) result = solve_level(s, number, s->desc->tolerance);
  if (!np_solver_state_begin(s, NP_STEP_FRAGILE)) return result;
  if (l->change) (void)np_parallel_for(s->context, NULL, count, MOMENTS, subtract_start, l);
  return result;
}

static neph_result solve_related(np_scattering_solver *s, double factor) {
  neph_result result = NEPH_OK;
  np_outflow blended;
  const bool is_new = np_solver_state_begin(s, NP_STEP_FRAGILE);
  if (is_new) blend_solution(s, factor);
  blended = s->outflow[s->band];
  for (unsigned n = s->level_count; n-- > np_scattering_solver_get_iterated(s) && !result;) {
    const bool is_finest = n == np_scattering_solver_get_iterated(s);
    if (is_finest) s->is_returned = is_returned(s);
    if (is_finest && is_new && n + 1 < s->level_count && s->is_returned) {
      s->outflow[s->band] = blended; /* coarse levels have renewed it by their own */
      np_scattering_solver_light_border(s);
    }
    result = change_level(s, n);
  }
  return result;
}

/* ---- All of a band ---- */

neph_result np_scattering_solver_solve_band(np_scattering_solver *s, bool is_first, double *sum) {
  const double before = *sum;
  s->state.has_fine = false;
  neph_result result = fill_emission(s);
  for (unsigned n = 0; n < s->level_count; n++)
    np_cell_air_set_band(&s->levels[n].grid, s->world, s->band, &s->levels[n].air);
  if (!result) result = light_levels(s, sum);
  if (result || *sum <= 0.0) return result;
  set_part(s, solving_begin, 1.0);
  np_monitor_set_stage(s->monitor, "solving multiple scattering");
  /* A band is not started from one that was cut: it would keep that band's colour. */
  s->is_nested = is_first || !(before > 0.0) || s->out->quality.is_cut;
  begin_budget(s);
  result = s->is_nested ? solve_nested(s) : solve_related(s, *sum / before);
  if (!result && !(s->is_transferred && s->turn > 0)) result = resolve(s);
  end_budget(s);
  set_part(s, keeping_begin, 1.0);
  return result;
}
