/* SPDX-License-Identifier: Apache-2.0 */
/* The result of a solver (scattering_solver.c), kept by cell: moments of the radiance in halves, and what the questions
 * that it answers need besides. Where the clouds are grey and the lights of one colour one band is solved for, and
 * kept. */
#include "transport/scattering_solver.h"

#include <string.h>

#include "core/alloc.h"
#include "core/half.h"
#include "core/math.h"
#include "transport/fires_apart.h"

enum { CHUNK = 1024, LANES = 16 };

/* Share of sunlight in the light of every band from which the angular resolution of the first band is used for all. */
static const double sun_share_min = 0.6;

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

/* ---- A band's result ---- */

/* Scale that brings the largest values between 2¹⁴ and 2¹⁵, so that only values below 4e-9 of the largest lose bits as
 * halves. */
static float choose_scale(const float *values, size_t count) {
  float lanes[LANES] = {0.0f}, largest = 0.0f;
  for (size_t i = 0; i < count - count % LANES; i += LANES)
    for (size_t lane = 0; lane < LANES; lane++) lanes[lane] = np_maxf(fabsf(values[i + lane]), lanes[lane]);
  for (size_t i = count - count % LANES; i < count; i++) largest = np_maxf(fabsf(values[i]), largest);
  for (size_t lane = 0; lane < LANES; lane++) largest = np_maxf(lanes[lane], largest);
  int exponent = 0;
  if (largest > 0.0f && isfinite(largest)) (void)frexpf(largest, &exponent);
  return ldexpf(1.0f, exponent > -110 ? exponent - 15 : -125);
}

/* Halves of a band's moments. */
typedef struct packing {
  const float *from;
  float inverse_scale;
  size_t count, stride; /* number of the band's moments in a cell, and of all bands' */
  uint16_t *to;
} packing;

static neph_result pack(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const packing *p = user;
  for (size_t active = begin; active < end; active++)
    for (size_t i = 0; i < p->count; i++)
      p->to[active * p->stride + i] = np_half_from_float(p->inverse_scale * p->from[active * p->count + i]);
  return NEPH_OK;
}

/* Keeps the present band's moments, `floats` in all. */
static neph_result pack_band(const np_scattering_solver *s, const float *values, size_t floats) {
  np_scattering_field *out = s->out;
  const size_t cells = s->levels[0].grid.active_count;
  const float scale = out->scale[s->band] = choose_scale(values, floats);
  packing p = {values, 1.0f / scale, s->band == 0 ? out->kept.first : out->kept.further,
               np_scattering_field_get_offset(out, out->medium.band_count),
               out->moments + np_scattering_field_get_offset(out, s->band)};
  return np_parallel_for(s->context, s->monitor, cells, CHUNK, pack, &p);
}

/* Light that the march replaces by the exact one: in means over cells, as the moments have it. */
static neph_result store_delta_m_residual(const np_scattering_solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  const size_t bands = s->out->medium.band_count;
  float *sharp = np_alloc(s->context, g->active_count, sizeof *sharp);
  if (!sharp) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(sharp, g->delta_m_residual, g->active_count * sizeof *sharp);
  const neph_result result = np_transport_grid_sharpen(g, 1, s->monitor, sharp);
  for (size_t active = 0; active < g->active_count && !result; active++)
    s->out->delta_m_residual[active * bands + s->band] = sharp[active];
  np_alloc_free(s->context, sharp);
  return result;
}

/* Sharpened in place, or in a copy where the next band starts from the solution. */
static neph_result store_band(np_scattering_solver *s) {
  np_transport_level *finest = &s->levels[0];
  const size_t floats = count_moments(&finest->grid);
  const unsigned count = np_harmonics_count(finest->grid.degree);
  float *copy = NULL, *sharp = finest->phi;
  np_workspace_clear(&s->workspace); /* the moments that are kept take its place */
  if (np_scattering_solver_get_iterated(s) == 0) {
    sharp = copy = np_alloc(s->context, floats, sizeof *copy);
    if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
    memcpy(copy, finest->phi, floats * sizeof *copy);
  }
  neph_result result = np_transport_grid_sharpen(&finest->grid, count, s->monitor, sharp);
  if (s->out->importance && !result)
    np_importance_add(finest, sharp, 1.0f / (float)s->out->medium.band_count, np_spectrum_max(s->world->sun_irradiance),
                      s->out->importance);
  if (!result) result = pack_band(s, sharp, floats);
  np_alloc_free(s->context, copy);
  return result || !finest->grid.delta_m_residual ? result : store_delta_m_residual(s);
}

/* Keeps, of a band that takes the angular resolution from the first one, what the first one's light times the ratio of
 * their sunlight leaves to the least degree. */
static neph_result store_transferred_band(np_scattering_solver *s) {
  const np_transport_level *iterated = &s->levels[np_scattering_solver_get_iterated(s)];
  const size_t floats = count_moments(&iterated->grid);
  neph_result result = np_workspace_begin(&s->workspace, floats, 1);
  if (result) return result;
  float *difference = np_workspace_take(&s->workspace, floats);
  for (size_t i = 0; i < floats; i++)
    difference[i] = iterated->phi[i] - s->out->first_ratio[s->band] * iterated->first_phi[i];
  result =
      np_transport_grid_sharpen(&iterated->grid, np_harmonics_count(iterated->grid.degree), s->monitor, difference);
  if (!result) result = pack_band(s, difference, floats);
  return result || !s->levels[0].grid.delta_m_residual ? result : store_delta_m_residual(s);
}

/* ---- Bands ---- */

/* Sums of all light on the clouds by band, and whether all of it is the first band's times `colour`. */
typedef struct light_colour {
  double sum[NP_BAND_COUNT];
  np_spectrum colour;
  bool is_one;
} light_colour;

static void add_light(light_colour *c, const float *first, size_t stride) {
  for (int b = 0; b < NP_BAND_COUNT; b++) c->sum[b] += (double)first[(size_t)b * stride];
}

static void check_light(light_colour *c, const float *first, size_t stride) {
  for (int b = 1; b < NP_BAND_COUNT; b++) {
    const float value = first[(size_t)b * stride], expected = c->colour.band[b] * first[0];
    c->is_one = c->is_one && fabsf(value - expected) <= 1e-5f * expected;
  }
}

/* Calls `visit` for the sunlight in each active cell, and for the boundary radiance along each ordinate. */
static void visit_lights(const np_scattering_solver *s, void (*visit)(light_colour *, const float *, size_t),
                         light_colour *colour) {
  const size_t stride = np_border_count_radiances(s->fine->border.clear[0].block_count);
  for (size_t active = 0; active < s->levels[0].grid.active_count; active++) visit(colour, s->sun[active].band, 1);
  for (size_t i = 0; i < stride; i++) visit(colour, s->fine->border.clear[0].radiance + i, stride);
}

/* The first band's solution is all bands' where clouds are grey and their lights have one colour. */
static void choose_bands(np_scattering_solver *s) {
  const bool has_own = s->world->emission || s->levels[0].air.sunlit; /* light of colours that are not the sun's */
  light_colour c = {.is_one = np_world_is_grey(s->world) && !has_own, .colour = np_spectrum_grey(1.0f)};
  if (c.is_one) visit_lights(s, add_light, &c);
  c.is_one = c.is_one && c.sum[0] > 0.0;
  for (int b = 0; b < NP_BAND_COUNT && c.is_one; b++) c.colour.band[b] = (float)(c.sum[b] / c.sum[0]);
  if (c.is_one) visit_lights(s, check_light, &c);
  s->out->medium.band_count = c.is_one ? 1 : NP_BAND_COUNT;
  s->out->medium.colour = c.is_one ? c.colour : np_spectrum_grey(1.0f);
}

/* Means of the sun's irradiance over sunlit cells, and of the boundary radiance as irradiance on a sphere. */
static void measure_light(np_scattering_solver *s, unsigned band) {
  const np_ordinates *o = &s->broad->ordinates;
  size_t sunlit = 0;
  for (size_t active = 0; active < s->levels[0].grid.active_count; active++) {
    sunlit += s->sun[active].band[0] > 0.0f;
    s->sunlight[band] += (double)s->sun[active].band[band];
  }
  s->sunlight[band] /= (double)(sunlit ? sunlit : 1);
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned i = 0; i < o->count; i++) {
      const unsigned block = i / NP_ORDINATE_LANES, lane = i % NP_ORDINATE_LANES;
      s->surroundings[band] +=
          0.25 * (double)(o->weight[block][lane]) * np_border_get_mean(&s->broad->border, band, octant, block, lane);
    }
}

/* Whether the other bands can take the change by the finer angular resolution from the first band. It mostly concerns
 * sunlight, and is alike in all bands. */
static bool can_transfer(const np_scattering_solver *s) {
  bool can = s->fine != s->broad && !s->levels[0].grid.is_fine && !s->desc->has_importance && !s->world->emission;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    can = can && s->sunlight[b] >= sun_share_min * (s->sunlight[b] + s->surroundings[b]);
  return can;
}

/* Bands of grey clouds differ in their light alone. */
static neph_result relate_bands(np_scattering_solver *s) {
  if (s->out->medium.band_count == 1 || !np_world_is_grey(s->world)) return NEPH_OK;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) measure_light(s, b);
  s->is_transferred = can_transfer(s);
  s->is_related = true;
  for (unsigned b = 1; b < NP_BAND_COUNT && s->is_transferred; b++)
    s->out->first_ratio[b] = s->sunlight[0] > 0.0 ? (float)(s->sunlight[b] / s->sunlight[0]) : 0.0f;
  const unsigned finest = np_scattering_solver_get_iterated(s);
  neph_result result = NEPH_OK;
  for (unsigned n = finest; n < s->level_count && !result; n++)
    result = np_transport_level_allocate_starts(&s->levels[n], n > finest);
  return result;
}

static neph_result compute_direct_irradiance(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_scattering_solver *s = user;
  const np_transport_grid *g = &s->levels[0].grid;
  for (size_t active = begin; active < end; active++)
    if (g->first_collision_source && g->first_collision_source[active] > 0.0f)
      s->sun[active] = np_world_sunlight(s->world, np_transport_grid_centre(g, g->cell[active]), s->world->to_sun);
  return NEPH_OK;
}

/* Allocates the bands' results on the active cells of the first band's grid. */
static neph_result allocate_result(const np_scattering_solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  np_scattering_field *out = s->out;
  const unsigned bands = out->medium.band_count, count = np_harmonics_count(g->degree);
  out->kept = (np_kept_moments){count, s->is_transferred ? np_harmonics_count(s->broad->ordinates.degree) : count};
  out->moments =
      np_alloc(s->context, g->active_count, np_scattering_field_get_offset(out, bands) * sizeof *out->moments);
  if (s->desc->has_importance) out->importance = np_alloc(s->context, g->active_count, sizeof *out->importance);
  if (g->delta_m_residual)
    out->delta_m_residual = np_alloc(s->context, g->active_count, bands * sizeof *out->delta_m_residual);
  const bool has_all =
      out->moments && (out->importance || !s->desc->has_importance) && (out->delta_m_residual || !g->delta_m_residual);
  return has_all ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Decides how the bands are solved for, and which of them. */
static neph_result start_bands(np_scattering_solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  s->sun = np_alloc(s->context, g->active_count, sizeof *s->sun);
  if (!s->sun) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(s->context, s->monitor, g->active_count, CHUNK, compute_direct_irradiance, s);
  if (result) return result;
  choose_bands(s);
  result = relate_bands(s);
  return result ? result : allocate_result(s);
}

/* Importance adds up over the bands, and would twice. What further bands start from is kept last: less memory is used
 * then. */
static neph_result store_solution(np_scattering_solver *s) {
  const bool is_new = np_solver_state_begin(s, s->out->importance ? NP_STEP_FRAGILE : NP_STEP_WITHIN);
  neph_result result = NEPH_OK;
  if (is_new) result = s->is_transferred && s->turn > 0 ? store_transferred_band(s) : store_band(s);
  if (s->is_transferred) np_transport_level_drop(&s->levels[0]);
  if (is_new && s->turn == 0) np_scattering_solver_keep_first(s);
  return result;
}

static neph_result solve_bands(np_scattering_solver *s) {
  const bool has_one_grid = np_world_is_grey(s->world);
  double sum = 0.0;
  s->out->medium.band_count = NP_BAND_COUNT;
  for (s->turn = 0; s->turn < s->out->medium.band_count; s->turn++) {
    s->band = np_scattering_band_order[s->turn];
    const bool is_first = s->turn == 0 || !has_one_grid;
    s->state.restart = 0;
    neph_result result = is_first ? np_scattering_solver_build_levels(s) : NEPH_OK;
    if (!result && s->turn == 0) result = start_bands(s);
    if (!result) result = np_scattering_solver_solve_band(s, is_first, &sum);
    if (!result && sum > 0.0) result = store_solution(s);
    if (result) return result;
  }
  if (s->out->importance) np_importance_spread(&s->levels[0].grid, s->out->importance);
  return NEPH_OK;
}

/* ---- All of it ---- */

static neph_result start_angles(np_scattering_solver *s, unsigned degree, bool is_layered, np_scattering_angles **out) {
  *out = np_alloc(s->context, 1, sizeof **out);
  if (!*out) return NEPH_ERROR_OUT_OF_MEMORY;
  np_scattering_angles *a = *out;
  np_ordinates_init(degree, is_layered, &a->ordinates);
  a->lights = (np_transport_lights){
      .context = s->context, .monitor = s->monitor, .ordinates = &a->ordinates, .workspace = &s->workspace};
  np_harmonics_eval(degree, np_vec3_scale(s->world->to_sun, -1.0f), a->lights.sun_harmonics);
  return NEPH_OK;
}

static neph_result fill_border(np_scattering_solver *s, const np_transport_grid *grid) {
  const np_border_set sets[] = {{&s->broad->ordinates, &s->broad->border}, {&s->fine->ordinates, &s->fine->border}};
  for (unsigned v = 0; v < s->all->clouds.count; v++) {
    const np_instance *cloud = &s->all->clouds.at[v];
    const float forward = np_scaled_phase_compute_forward(&cloud->phase, s->broad->ordinates.degree);
    s->fade[v] = 1.0f - forward * np_spectrum_max(cloud->albedo);
  }
  return np_border_fill(grid, s->world, s->depths, s->fade, s->monitor, s->desc->tolerance >= NP_SCATTERING_ROUGH, sets,
                        s->fine == s->broad ? 1 : 2);
}

/* Scaled phase functions of all clouds for the field, and of the solved clouds in their order. */
static neph_result start_phases(np_scattering_solver *s, unsigned degree) {
  neph_result result = np_scattering_field_build_phases(s->all, degree, s->out);
  for (unsigned v = 0; v < s->world->clouds.count && !result; v++) s->phases[v] = s->out->phases[s->solved->number[v]];
  return result;
}

static neph_result start(np_scattering_solver *s) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(s->context, s->world, &s->desc->cells, &grid);
  if (result) return result;
  const bool is_layered = grid.is_wrapped[0] || grid.is_wrapped[1], is_fine_wanted = grid.is_fine;
  const double cells = (double)np_transport_grid_count(&grid);
  const np_scattering_degrees d = np_scattering_desc_choose_degrees(s->desc, cells, is_layered, is_fine_wanted);
  result = start_angles(s, d.iterated, is_layered, &s->broad);
  if (!result && d.resolved != d.iterated) result = start_angles(s, d.resolved, is_layered, &s->fine);
  if (!s->fine) s->fine = s->broad;
  if (!result) result = fill_border(s, &grid);
  np_transport_grid_clear(&grid);
  return result ? result : start_phases(s, d.resolved);
}

static void report(const np_world *world, double tolerance, np_scattering_field *field) {
  const np_transport_grid *g = &field->grid;
  np_scattering_quality *q = &field->quality;
  double least, most;
  np_transport_grid_compute_depths(world, g, &least, &most);
  /* Cells of a column are large only where light is nearly constant. */
  const double lit = np_transport_grid_compute_lit_depth(g);
  q->error = np_transport_expect_deep_error(np_transport_grid_is_column(g) ? least : most, lit, g->is_flat);
  np_log(field->context, NEPH_LOG_DEBUG,
         "multiple scattering: %d x %d x %d cells, %zu in cloud, degree %u, residual %.2g after %u sweeps", g->size[0],
         g->size[1], g->size[2], g->active_count, g->degree, q->residual, field->sweeps);
  np_log(
      field->context, NEPH_LOG_DEBUG,
      "multiple scattering: the densest cells have a scaled depth of %.2g to %.2g, those that sunlight meets first of "
      "%.2g; expected error %.2g %%",
      least, most, lit, 100.0 * q->error);
  if (q->residual > 10.0 * tolerance && !q->is_cut)
    np_log(field->context, NEPH_LOG_WARNING, "multiple scattering has not converged: residual %.2g, wanted %.2g",
           q->residual, tolerance);
}

/* Moves the finest cells from the solver to the result. */
static void finish(np_scattering_solver *s) {
  s->out->grid = s->levels[0].grid;
  s->out->has_whole_grid = np_world_is_grey(s->world) && !(s->out->grid.fold.period_m > 0.0);
  s->levels[0].grid = (np_transport_grid){.context = s->context};
  s->out->medium.has_delta_m_residual = s->out->delta_m_residual;
  if (s->out->grid.fold.period_m > 0.0) np_fold_light_fill(s->world, &s->out->grid.fold, &s->out->fold_light);
  report(s->world, s->desc->tolerance, s->out);
}

static void clear_angles(neph_context *context, np_scattering_angles *angles) {
  if (angles) np_border_clear(context, &angles->border);
  np_alloc_free(context, angles);
}

static neph_result run(np_scattering_solver *s) {
  np_solver_state_open(s);
  neph_result result = start(s);
  if (!result) result = solve_bands(s);
  if (!result) result = np_solver_state_check(s);
  if (!result) finish(s);
  if (result == NEPH_ERROR_CANCELLED) np_solver_state_save_last(s);
  np_solver_state_close(s);
  np_scattering_solver_clear_levels(s);
  np_workspace_clear(&s->workspace);
  np_alloc_free(s->context, s->sun);
  np_ground_columns_clear(s->context, &s->ground);
  if (s->fine != s->broad) clear_angles(s->context, s->fine);
  clear_angles(s->context, s->broad);
  return result;
}

/* A state that does not fit is left alone, whatever its checksum says. */
static neph_result solve_clouds(neph_context *context, const np_world *all, const np_solved_clouds *solved,
                                const np_sun_optical_depth_source *depths, const np_scattering_desc *desc,
                                np_monitor *monitor, np_scattering_field **out_field) {
  neph_result result = NEPH_ERROR_BAD_FILE;
  np_scattering_solver initial = {.context = context,
                                  .world = &solved->world,
                                  .solved = solved,
                                  .all = all,
                                  .depths = depths,
                                  .desc = desc,
                                  .monitor = monitor,
                                  .workspace = {.context = context},
                                  .state = {.keeper = desc->keeper},
                                  .whole = np_monitor_get_part(monitor)};
  initial.end_s = isfinite(desc->seconds_max) ? np_monitor_get_seconds(monitor) + desc->seconds_max : HUGE_VAL;
  for (int attempt = 0; attempt < 2 && result == NEPH_ERROR_BAD_FILE; attempt++) {
    np_scattering_solver s = initial;
    s.state.is_anew = attempt > 0;
    s.out = np_scattering_field_create(context);
    if (!s.out) return NEPH_ERROR_OUT_OF_MEMORY;
    result = run(&s);
    if (result)
      np_scattering_field_destroy(s.out);
    else
      *out_field = s.out;
  }
  return result;
}

/* Half of the time and of the progress are those of the fires, whose states are not kept. */
static neph_result solve_fires_apart(neph_context *context, const np_world *all, const np_solved_clouds *solved,
                                     const np_sun_optical_depth_source *depths, const np_scattering_desc *desc,
                                     np_monitor *monitor, np_scattering_field **out_field) {
  const np_monitor_part whole = np_monitor_get_part(monitor);
  np_solved_clouds others = *solved, fires = *solved;
  np_scattering_desc half = *desc;
  np_scattering_field *fields[2] = {NULL};
  half.seconds_max = 0.5 * desc->seconds_max;
  half.reused = NULL;
  others.world = np_fires_leave_out(&solved->world);
  fires.world = np_fires_leave_alone(&solved->world);
  np_monitor_set_part(monitor, whole, 0.0, 0.5);
  neph_result result = solve_clouds(context, all, &others, depths, &half, monitor, &fields[0]);
  half.keeper = NULL;
  half.cells.has_open_sides = true;
  np_monitor_set_part(monitor, whole, 0.5, 1.0);
  if (!result) result = solve_clouds(context, all, &fires, depths, &half, monitor, &fields[1]);
  if (!result) result = np_scattering_field_add_fires(fields[0], fields[1], all, monitor, out_field);
  for (int i = 0; i < 2; i++) np_scattering_field_destroy(fields[i]);
  return result;
}

static neph_result solve(neph_context *context, const np_world *all, const np_solved_clouds *solved,
                         const np_sun_optical_depth_source *depths, const np_scattering_desc *desc, np_monitor *monitor,
                         np_scattering_field **out_field) {
  if (solved->world.clouds.count == 0) return np_scattering_field_make_dark(context, all, &desc->cells, out_field);
  return np_scattering_has_fires_apart(&solved->world)
             ? solve_fires_apart(context, all, solved, depths, desc, monitor, out_field)
             : solve_clouds(context, all, solved, depths, desc, monitor, out_field);
}

neph_result np_scattering_field_build(neph_context *context, const np_world *world,
                                      const np_sun_optical_depth_source *depths, const np_scattering_desc *desc,
                                      np_monitor *monitor, np_scattering_field **out_field) {
  np_solved_clouds solved;
  *out_field = NULL;
  neph_result result = np_solved_clouds_list(context, world, desc->left_out, &solved);
  if (!result) result = solve(context, world, &solved, depths, desc, monitor, out_field);
  np_solved_clouds_clear(&solved);
  return result;
}
