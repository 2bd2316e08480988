/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/scattering_solver.h"

/* In the order of the file; then the levels, the bands that are finished, and the iteration. */
typedef struct state_header {
  uint32_t step, turn, level_count, first_level, sweeps, has_history;
  double residual;
  float scale[NP_BAND_COUNT];
} state_header;

typedef struct history_header {
  uint32_t depth, count, calls, is_stalled, idle, padding;
  double residual, first, before, best;
} history_header;

typedef enum value_kind { FLOATS, HALVES } value_kind;

/* Reads a block into its place, or writes it from there. */
typedef void transfer_fn(np_cache_entry *entry, void *block, size_t size, value_kind kind);

/* Exponents of infinities and of what is no number have all their bits set. */
static bool are_finite(const void *block, size_t size, value_kind kind) {
  const uint32_t *floats = block;
  const uint16_t *halves = block;
  bool are = true;
  for (size_t i = 0; kind == FLOATS && i < size / sizeof *floats; i++)
    are = are && (floats[i] & 0x7f800000u) != 0x7f800000u;
  for (size_t i = 0; kind == HALVES && i < size / sizeof *halves; i++) are = are && (halves[i] & 0x7c00u) != 0x7c00u;
  return are;
}

/* Light that is not finite, whatever the checksum says, is none. */
static void read_block(np_cache_entry *entry, void *block, size_t size, value_kind kind) {
  if (np_cache_read(entry, block, size) && !are_finite(block, size, kind)) entry->is_good = false;
}

static void write_block(np_cache_entry *entry, void *block, size_t size, value_kind kind) {
  (void)kind;
  np_cache_write(entry, block, size);
}

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

/* ---- Solution ---- */

static void transfer_levels(np_scattering_solver *s, unsigned first, np_cache_entry *entry, transfer_fn *transfer) {
  for (unsigned n = first; n < s->level_count; n++) {
    np_transport_level *l = &s->levels[n];
    const size_t size = count_moments(&l->grid) * sizeof *l->phi;
    transfer(entry, l->phi, size, FLOATS);
    if (l->first_phi) transfer(entry, l->first_phi, size, FLOATS);
    if (l->change) transfer(entry, l->change, size, FLOATS);
  }
}

/* Before the second band there is none. */
static void transfer_bands(np_scattering_solver *s, np_cache_entry *entry, transfer_fn *transfer) {
  np_scattering_field *out = s->out;
  const np_transport_grid *g = &s->levels[0].grid;
  if (s->turn == 0) return;
  transfer(entry, out->moments, count_moments(g) * out->medium.band_count * sizeof *out->moments, HALVES);
  if (out->delta_m_residual)
    transfer(entry, out->delta_m_residual, g->active_count * out->medium.band_count * sizeof *out->delta_m_residual,
             FLOATS);
  if (out->importance) transfer(entry, out->importance, g->active_count * sizeof *out->importance, FLOATS);
}

static void write_solution(np_scattering_solver *s, unsigned step, bool has_history, np_cache_entry *entry) {
  state_header h = {.step = step,
                    .turn = s->turn,
                    .level_count = s->level_count,
                    .first_level = s->state.has_fine ? 0 : np_scattering_solver_get_iterated(s),
                    .sweeps = s->out->sweeps,
                    .has_history = has_history,
                    .residual = s->out->quality.residual};
  for (int b = 0; b < NP_BAND_COUNT; b++) h.scale[b] = s->out->scale[b];
  NP_CACHE_WRITE(entry, h);
  transfer_levels(s, h.first_level, entry, write_block);
  transfer_bands(s, entry, write_block);
}

/* Whether a header is of the present band and of these levels, with a residual and scales that a solution may have. */
static bool is_sound(const np_scattering_solver *s, const state_header *h) {
  const unsigned iterated = np_scattering_solver_get_iterated(s);
  bool is = h->turn == s->turn && h->level_count == s->level_count && h->first_level < h->level_count &&
            (h->first_level == 0 || h->first_level == iterated) && isfinite(h->residual) && h->residual >= 0.0;
  for (int b = 0; b < NP_BAND_COUNT; b++) is = is && isfinite(h->scale[b]) && h->scale[b] >= 0.0f;
  return is;
}

/* The header was read when the entry was opened, to learn its step. */
static void read_solution(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  np_cache_entry *entry = &state->entry;
  state_header h;
  if (!NP_CACHE_READ(entry, h) || !is_sound(s, &h)) {
    state->is_damaged = true;
    return;
  }
  transfer_levels(s, h.first_level, entry, read_block);
  transfer_bands(s, entry, read_block);
  state->is_damaged = !entry->is_good;
  state->has_history = h.has_history;
  state->has_fine = h.first_level == 0;
  s->out->sweeps = h.sweeps;
  s->out->quality.residual = h.residual;
  for (int b = 0; b < NP_BAND_COUNT; b++) s->out->scale[b] = h.scale[b];
}

/* ---- Iteration ---- */

static void transfer_history(const np_fixed_point_history *history, size_t count, np_cache_entry *entry,
                             transfer_fn *transfer) {
  for (unsigned j = 0; j < history->count; j++) {
    transfer(entry, history->image[j], count * sizeof(float), FLOATS);
    transfer(entry, history->residual[j], count * sizeof(float), FLOATS);
  }
}

/* An iteration that goes on has calls left. */
static bool is_history(const history_header *h, const np_fixed_point *problem) {
  return h->depth >= 1 && h->depth <= problem->depth && h->count <= h->depth && h->calls < problem->calls_max &&
         h->residual >= 0.0 && h->first >= 0.0 && h->before >= 0.0 && h->best >= 0.0 && h->is_stalled <= 1;
}

static bool is_gram(const np_fixed_point_history *history, unsigned count) {
  bool is = true;
  for (unsigned i = 0; i < count; i++)
    for (unsigned j = 0; j < count; j++) is = is && isfinite(history->gram[i][j]);
  return is;
}

bool np_solver_state_load_history(void *user, np_fixed_point *problem, np_fixed_point_history *history) {
  np_scattering_solver *s = user;
  np_solver_state *state = &s->state;
  history_header h;
  if (state->step != state->resumed || !state->has_history) return false;
  state->has_history = false;
  const bool is_read = NP_CACHE_READ(&state->entry, h) && is_history(&h, problem) &&
                       NP_CACHE_READ(&state->entry, history->gram) && NP_CACHE_READ(&state->entry, history->relative) &&
                       is_gram(history, h.count);
  if (is_read) {
    history->depth = h.depth;
    history->count = h.count;
    history->first = h.first;
    history->before = h.before;
    history->best = h.best;
    history->idle = h.idle;
    transfer_history(history, problem->count, &state->entry, read_block);
    problem->calls = h.calls;
    problem->residual = h.residual;
    problem->is_stalled = h.is_stalled;
  }
  state->is_damaged = !np_cache_read_end(&state->entry) || !is_read || state->is_damaged;
  return is_read;
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
  transfer_history(history, problem->count, entry, write_block);
}

/* ---- Steps ---- */

static void write_state(np_scattering_solver *s, unsigned step, const np_fixed_point *problem,
                        const np_fixed_point_history *history) {
  const np_solution_keeper *keeper = s->state.keeper;
  np_cache_entry entry;
  if (!keeper->write_begin(keeper->user, &entry)) return;
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
  const size_t start = state->entry.at;
  if (NP_CACHE_READ(&state->entry, h) && h.step > 0)
    state->resumed = h.step;
  else
    (void)np_cache_read_end(&state->entry);
  state->entry.at = start;
}

bool np_solver_state_begin(np_scattering_solver *s, np_step_kind kind) {
  np_solver_state *state = &s->state;
  state->step++;
  if (!state->keeper) return true;
  if (kind != NP_STEP_WITHIN) state->restart = kind == NP_STEP_RESTARTABLE ? state->step : 0;
  if (state->step < state->resumed) return false;
  if (state->step == state->resumed) {
    read_solution(s);
    if (!state->has_history && !np_cache_read_end(&state->entry)) state->is_damaged = true;
    np_log(s->context, NEPH_LOG_INFO, "multiple scattering: resumed in band %u of %u", s->turn + 1,
           s->out->medium.band_count);
  } else if (is_due(s)) {
    write_state(s, state->step, NULL, NULL);
  }
  return true;
}

void np_solver_state_save_history(void *user, const np_fixed_point *problem, const np_fixed_point_history *history,
                                  bool is_last) {
  np_scattering_solver *s = user;
  if (!is_last && !is_due(s)) return;
  write_state(s, s->state.step, problem, history);
  s->state.is_last = is_last;
}

void np_solver_state_keep_last(np_scattering_solver *s) {
  np_solver_state *state = &s->state;
  if (!state->keeper || state->is_last || state->restart == 0 || state->step < state->resumed) return;
  write_state(s, state->restart, NULL, NULL);
}

/* Its step may be one that the solution does not have. */
bool np_solver_state_is_damaged(const np_scattering_solver *s) {
  return s->state.is_damaged || s->state.step < s->state.resumed;
}

neph_result np_solver_state_refuse(np_scattering_solver *s) {
  np_cache_entry *entry = &s->state.entry;
  if (s->state.keeper && entry->path) {
    entry->is_good = false;
    (void)np_cache_read_end(entry);
  }
  return NEPH_ERROR_BAD_FILE;
}

void np_solver_state_close(np_scattering_solver *s) {
  if (s->state.keeper && s->state.entry.path) np_cache_read_close(&s->state.entry);
}
