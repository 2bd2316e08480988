/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/alloc.h"
#include "transport/scattering_solver.h"

/* Header of a state, followed by the levels, the finished bands, and the iteration. */
typedef struct state_header {
  uint32_t step, turn, level_count, first_level, sweeps, has_history, has_outflow, padding;
  double residual;
  float scale[NP_BAND_COUNT];
} state_header;

typedef struct history_header {
  uint32_t depth, count, calls, is_stalled, idle, padding;
  double residual, first, before, best;
} history_header;

/* Transfer of a state's arrays in one of two directions: from the entry, or to it. */
typedef struct state_transfer {
  void (*floats)(np_cache_entry *entry, float *values, size_t count);
  void (*halves)(np_cache_entry *entry, uint16_t *values, size_t count);
} state_transfer;

/* Light that is not finite is none, whatever the checksum is. */
static void read_floats(np_cache_entry *entry, float *values, size_t count) {
  if (np_cache_read(entry, values, count * sizeof *values))
    (void)np_cache_read_check(entry, np_cache_are_finite(values, count));
}

static void read_halves(np_cache_entry *entry, uint16_t *values, size_t count) {
  uint16_t *block = np_cache_read_halves(entry, count);
  if (block) memcpy(values, block, count * sizeof *values);
  np_alloc_free(entry->context, block);
}

static void write_floats(np_cache_entry *entry, float *values, size_t count) {
  np_cache_write(entry, values, count * sizeof *values);
}

static void write_halves(np_cache_entry *entry, uint16_t *values, size_t count) {
  np_cache_write(entry, values, count * sizeof *values);
}

static const state_transfer reading = {read_floats, read_halves}, writing = {write_floats, write_halves};

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

/* ---- Solution ---- */

/* Irradiances of all bands: a further band begins from the bands before it. */
static void transfer_outflow(np_scattering_solver *s, np_cache_entry *entry, const state_transfer *way) {
  way->floats(entry, &s->outflow[0].way[0][0][0], sizeof s->outflow / (sizeof(float)));
}

static void transfer_levels(np_scattering_solver *s, unsigned first, np_cache_entry *entry, const state_transfer *way) {
  for (unsigned n = first; n < s->level_count; n++) {
    np_transport_level *l = &s->levels[n];
    const size_t count = count_moments(&l->grid);
    way->floats(entry, l->phi, count);
    if (l->first_phi) way->floats(entry, l->first_phi, count);
    if (l->change) way->floats(entry, l->change, count);
  }
}

/* Transfers the finished bands; there are none before the second band. */
static void transfer_bands(np_scattering_solver *s, np_cache_entry *entry, const state_transfer *way) {
  np_scattering_field *out = s->out;
  const np_transport_grid *g = &s->levels[0].grid;
  if (s->turn == 0) return;
  way->halves(entry, out->moments, g->active_count * np_scattering_field_get_offset(out, out->medium.band_count));
  if (out->delta_m_residual) way->floats(entry, out->delta_m_residual, g->active_count * out->medium.band_count);
  if (out->importance)
    way->floats(entry, &out->importance->mean, g->active_count * (sizeof *out->importance / sizeof(float)));
}

static void write_solution(np_scattering_solver *s, unsigned step, bool has_history, np_cache_entry *entry) {
  state_header h = {.step = step,
                    .turn = s->turn,
                    .level_count = s->level_count,
                    .first_level = s->state.has_fine ? 0 : np_scattering_solver_get_iterated(s),
                    .sweeps = s->out->sweeps,
                    .has_history = has_history,
                    .has_outflow = s->has_outflow,
                    .residual = s->out->quality.residual};
  for (int b = 0; b < NP_BAND_COUNT; b++) h.scale[b] = s->out->scale[b];
  NP_CACHE_WRITE(entry, h);
  transfer_outflow(s, entry, &writing);
  transfer_levels(s, h.first_level, entry, &writing);
  transfer_bands(s, entry, &writing);
}

/* Whether a header is of the present band and of these levels, with a residual and scales that a solution may have. */
static bool is_sound(const np_scattering_solver *s, const state_header *h) {
  bool is_light = isfinite(h->residual) && h->residual >= 0.0;
  for (int b = 0; b < NP_BAND_COUNT; b++) is_light = is_light && isfinite(h->scale[b]) && h->scale[b] >= 0.0f;
  return is_light && h->turn == s->turn && h->level_count == s->level_count && h->has_history <= 1 &&
         h->has_outflow <= 1 &&
         (h->first_level == 0 ? s->levels[0].phi != NULL : h->first_level == np_scattering_solver_get_iterated(s));
}

/* The header was examined when the entry was opened, to learn its step. */
static void read_solution(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  np_cache_entry *entry = &state->entry;
  state_header h;
  if (!NP_CACHE_READ(entry, h) || !np_cache_read_check(entry, is_sound(s, &h))) return;
  transfer_outflow(s, entry, &reading);
  transfer_levels(s, h.first_level, entry, &reading);
  transfer_bands(s, entry, &reading);
  if (!entry->is_good) return;
  state->has_history = h.has_history;
  state->has_fine = h.first_level == 0;
  s->has_outflow = h.has_outflow;
  np_scattering_solver_light_border(s);
  s->out->sweeps = h.sweeps;
  s->out->quality.residual = h.residual;
  for (int b = 0; b < NP_BAND_COUNT; b++) s->out->scale[b] = h.scale[b];
}

/* Restores the state when its step is reached. */
static void resume(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  read_solution(s);
  if (!state->has_history) state->is_damaged = !np_cache_read_end(&state->entry);
  if (state->is_damaged) return;
  np_log(s->context, NEPH_LOG_INFO, "multiple scattering: resumed in band %u of %u", s->turn + 1,
         s->out->medium.band_count);
}

/* ---- Iteration ---- */

static void transfer_history(const np_fixed_point_history *history, size_t count, np_cache_entry *entry,
                             const state_transfer *way) {
  for (unsigned j = 0; j < history->count; j++) {
    way->floats(entry, history->image[j], count);
    way->floats(entry, history->residual[j], count);
  }
}

/* Checks the history of an unfinished iteration: it must have calls left. */
static bool is_history(const history_header *h, const np_fixed_point *problem) {
  return h->depth >= 1 && h->depth <= problem->depth && h->count <= h->depth && h->calls < problem->calls_max &&
         h->is_stalled <= 1 && h->residual >= 0.0 && h->first >= 0.0 && h->before >= 0.0 && h->best >= 0.0;
}

static bool are_products_finite(const np_fixed_point_history *history, unsigned count) {
  bool are = np_cache_are_doubles_finite(history->relative, count);
  for (unsigned i = 0; i < count; i++) are = are && np_cache_are_doubles_finite(history->gram[i], count);
  return are;
}

static bool read_history(np_cache_entry *entry, const np_fixed_point *problem, history_header *h,
                         np_fixed_point_history *out) {
  if (!NP_CACHE_READ(entry, *h) || !np_cache_read_check(entry, is_history(h, problem))) return false;
  if (!NP_CACHE_READ(entry, out->gram) || !NP_CACHE_READ(entry, out->relative)) return false;
  if (!np_cache_read_check(entry, are_products_finite(out, h->count))) return false;
  out->count = h->count;
  transfer_history(out, problem->count, entry, &reading);
  return entry->is_good;
}

bool np_solver_state_load_history(void *user, np_fixed_point *problem, np_fixed_point_history *history) {
  np_scattering_solver *s = user;
  np_solver_state *state = &s->state;
  history_header h;
  if (state->step != state->resumed || !state->has_history) return false;
  state->has_history = false;
  const bool is_read = read_history(&state->entry, problem, &h, history);
  state->is_damaged = !np_cache_read_end(&state->entry) || !is_read;
  if (state->is_damaged) {
    history->count = 0;
    return false;
  }
  history->depth = h.depth;
  history->first = h.first;
  history->before = h.before;
  history->best = h.best;
  history->idle = h.idle;
  problem->calls = h.calls;
  problem->residual = h.residual;
  problem->is_stalled = h.is_stalled;
  return true;
}

static void write_history(const np_fixed_point *problem, const np_fixed_point_history *history, np_cache_entry *entry) {
  history_header h = {.depth = history->depth,
                      .count = history->count,
                      .calls = problem->calls,
                      .is_stalled = problem->is_stalled,
                      .idle = history->idle,
                      .residual = problem->residual,
                      .first = history->first,
                      .before = history->before,
                      .best = history->best};
  NP_CACHE_WRITE(entry, h);
  NP_CACHE_WRITE(entry, history->gram);
  NP_CACHE_WRITE(entry, history->relative);
  transfer_history(history, problem->count, entry, &writing);
}

/* ---- Steps ---- */

/* A solution that was resumed from a damaged state is not kept. */
static void write_state(np_scattering_solver *s, unsigned step, const np_fixed_point *problem,
                        const np_fixed_point_history *history) {
  const np_solution_keeper *keeper = s->state.keeper;
  np_cache_entry entry;
  if (s->state.is_damaged || !keeper->write_begin(keeper->user, &entry)) return;
  write_solution(s, step, history != NULL, &entry);
  if (history) write_history(problem, history, &entry);
  np_cache_write_commit(&entry);
  s->state.last_s = np_monitor_get_seconds(s->monitor);
  np_log(s->context, NEPH_LOG_DEBUG, "multiple scattering: checkpoint written, at step %u of band %u", step,
         s->turn + 1);
}

static bool is_due(const np_scattering_solver *s) {
  const np_solver_state *state = &s->state;
  return state->keeper && !state->is_last &&
         np_monitor_get_seconds(s->monitor) - state->last_s >= state->keeper->interval_s;
}

void np_solver_state_open(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  state_header h;
  if (isfinite(s->desc->seconds_max)) state->keeper = NULL;
  if (!state->keeper) return;
  state->last_s = np_monitor_get_seconds(s->monitor);
  if (state->is_anew || !state->keeper->read_begin(state->keeper->user, &state->entry)) return;
  if (!np_cache_read_verify(&state->entry)) return;
  if (np_cache_peek(&state->entry, &h, sizeof h) && np_cache_read_check(&state->entry, h.step > 0))
    state->resumed = h.step;
  else
    (void)np_cache_read_end(&state->entry);
}

/* A history that the step of its state does not take up is damage. */
bool np_solver_state_begin(np_scattering_solver *s, np_step_kind kind) {
  np_solver_state *state = &s->state;
  state->step++;
  if (!state->keeper) return true;
  if (kind != NP_STEP_WITHIN) state->restart = kind == NP_STEP_RESTARTABLE ? state->step : 0;
  if (state->step < state->resumed) return false;
  state->is_damaged = state->is_damaged || state->has_history;
  if (state->step == state->resumed)
    resume(s);
  else if (is_due(s))
    write_state(s, state->step, NULL, NULL);
  return !state->is_damaged;
}

void np_solver_state_save_history(void *user, const np_fixed_point *problem, const np_fixed_point_history *history,
                                  bool is_last) {
  np_scattering_solver *s = user;
  if (!is_last && !is_due(s)) return;
  write_state(s, s->state.step, problem, history);
  s->state.is_last = is_last;
}

void np_solver_state_save_last(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  if (!state->keeper || state->is_last || state->restart == 0 || state->step < state->resumed) return;
  write_state(s, state->restart, NULL, NULL);
}

/* The entry's step may be one that the solution does not have. */
neph_result np_solver_state_check(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  if (!state->is_damaged && !state->has_history && state->step >= state->resumed) return NEPH_OK;
  if (state->entry.path) {
    (void)np_cache_read_check(&state->entry, false);
    (void)np_cache_read_end(&state->entry);
  }
  return NEPH_ERROR_BAD_FILE;
}

void np_solver_state_close(np_scattering_solver *s) {
  if (s->state.keeper && s->state.entry.path) np_cache_read_close(&s->state.entry);
}
