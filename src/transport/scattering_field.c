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
 * maps φ to the φ of its solution; Anderson acceleration finds the fixed point, on the coarsest grid first, then from
 * there on finer ones.
 *
 * Small clouds are solved to a high degree from the start. Larger ones get the least degree, and where the memory
 * allows it that solution is then resolved into more: a high degree counts less of the sun's light as having gone
 * straight on, the rest is in φ, and from there on sweeps do but what is local, which they do well. So is what large
 * pictures show within cells: fine ones, half as wide, start from there and are swept likewise.
 *
 * A band starts from the one before it, in proportion to their sources. Where the clouds are grey and the lights of one
 * colour, that is the solution: one band is solved for, and kept.
 */
#include "transport/scattering_field.h"

#include <string.h>

#include "core/alloc.h"
#include "transport/transport_level.h"

enum {
  LEVELS_MAX = 6,
  CHUNK = 4096,
  RESOLVED_DEGREE = 7,
  /* A third of either changes a picture by a tenth of a per cent. */
  RESOLVING_SWEEPS = 2,
  REFINING_SWEEPS = 2 /* of fine cells */
};

/* A fine cell takes half as long as a ray of the march, with or without cloud in both: where these many are no more, of
 * a picture's time less than half goes into cells. */
static const double cells_per_ray = 1.5;

/* Directions, and what comes along them from outside. */
typedef struct angles {
  np_ordinates ordinates;
  np_boundary_radiance boundary;
  np_transport_lights lights;
} angles;

/* How far the solution of a band has come. */
typedef struct reach {
  unsigned level;  /* the last that was swept; the number of levels: none */
  unsigned sweeps; /* of that level, where they were cut; 0: up to its tolerance */
  double residual;
} reach;

typedef struct solver {
  neph_context *context;
  const np_world *world;
  const np_sun_depth_source *depths;
  const np_scattering_desc *desc;
  np_monitor *monitor;
  np_scattering_field *out;
  angles *fine, *broad; /* of the result, and of what is iterated; the same where nothing is to be resolved further */
  np_spectrum *sun;     /* irradiance at each live cell of the finest grid */
  double end_s;         /* of the monitor's seconds, for the sweeps of all bands; infinite: no limit */
  bool has_time;        /* the present band's share of them is not used up */
  reach reached, cut;   /* by the present band; and by the last one that was cut, past which no other goes */
  np_monitor_part whole;
  unsigned level_count, band;
  /* The result's; where its cells are fine, those twice as wide; then the same in the degree that is iterated, if that
   * is another; then coarser ones. */
  np_transport_level levels[LEVELS_MAX];
} solver;

static bool is_fine(const solver *s) { return s->levels[0].grid.is_fine; }
static bool is_resolved(const solver *s) { return s->fine != s->broad; }

/* The finest that is iterated. */
static unsigned get_iterated(const solver *s) { return (is_fine(s) ? 1u : 0u) + (is_resolved(s) ? 1u : 0u); }

/* ---- Time and progress ---- */

/* Of a band's work, where sweeps begin and where they give way to the last ones. */
static const double solving_begin = 0.15, resolving_begin = 0.85, keeping_begin = 0.95;

/* What follows is [begin, end] of the band's work. */
static void set_part(const solver *s, double begin, double end) {
  const double count = s->out->band_count;
  np_monitor_set_part(s->monitor, s->whole, (s->band + begin) / count, (s->band + end) / count);
}

/* A level takes time as it has cells. */
static void set_level_part(const solver *s, unsigned number) {
  double all = 0.0, before = 0.0;
  for (unsigned n = get_iterated(s); n < s->level_count; n++) {
    all += (double)s->levels[n].grid.active_count;
    if (n > number) before += (double)s->levels[n].grid.active_count;
  }
  const double per_cell = (resolving_begin - solving_begin) / fmax(all, 1.0), begin = solving_begin + per_cell * before;
  set_part(s, begin, begin + per_cell * (double)s->levels[number].grid.active_count);
}

/* The band is as it is. */
static void note_cut(solver *s) {
  const unsigned width = 1u << (s->reached.level - get_iterated(s));
  s->has_time = false;
  s->cut = s->reached;
  s->out->is_cut = true;
  s->out->residual = fmax(s->out->residual, s->reached.residual);
  s->out->cut_width = width > s->out->cut_width ? width : s->out->cut_width;
}

/* The band's share of the time that is left; a little less for those before the last, which come as far as the first
 * was cut, that they can. */
static void begin_budget(solver *s, bool is_nested) {
  const unsigned bands_left = s->out->band_count - s->band;
  s->has_time = true;
  if (is_nested) s->reached = (reach){.level = s->level_count, .residual = 1.0};
  if (!isfinite(s->end_s)) return;
  const double now_s = np_monitor_get_seconds(s->monitor), share = (bands_left > 1 ? 0.9 : 1.0) / bands_left;
  if (now_s < s->end_s)
    np_monitor_begin_budget(s->monitor, now_s + share * (s->end_s - now_s));
  else
    note_cut(s);
}

static void end_budget(solver *s) {
  if (np_monitor_end_budget(s->monitor)) note_cut(s);
}

/* ---- Levels ---- */

/* A band comes no further than the one before that was cut: else the clouds would take on its colour. */
static neph_result solve_level(solver *s, unsigned number, double tolerance) {
  if (s->out->is_cut && number < s->cut.level) return NEPH_OK;
  np_transport_level *level = &s->levels[number];
  np_transport_effort effort = {.tolerance = tolerance, .is_finest = number == get_iterated(s)};
  if (s->out->is_cut && number == s->cut.level) effort.sweeps_max = s->cut.sweeps;
  set_level_part(s, number);
  neph_result result = np_transport_level_solve(&s->broad->lights, level, &effort);
  if (effort.sweeps > 0) s->reached = (reach){number, effort.is_cut ? effort.sweeps : 0, effort.residual};
  if (effort.is_cut) end_budget(s);
  if (!effort.is_finest || effort.is_cut) return result;
  s->out->residual = fmax(s->out->residual, effort.residual);
  s->out->sweeps += effort.sweeps;
  return result;
}

/* From the next coarser level, whether or not there is time: it is little, and what stands there now is nothing. */
static neph_result prolong(solver *s, unsigned number) {
  neph_result result = np_transport_level_prolong(&s->levels[number + 1], s->monitor, &s->levels[number]);
  if (result != NEPH_ERROR_CANCELLED || !np_monitor_is_cut(s->monitor)) return result;
  end_budget(s);
  return np_transport_level_prolong(&s->levels[number + 1], s->monitor, &s->levels[number]);
}

static neph_result solve_nested(solver *s) {
  const unsigned finest = get_iterated(s);
  neph_result result = NEPH_OK;
  for (unsigned n = s->level_count; n-- > finest && !result;) {
    if (n + 1 < s->level_count) result = prolong(s, n);
    if (result || !s->has_time) continue;
    /* What crosses a thick cloud slowly, and shows late in the residual, is found on coarse cells: they are cheap. */
    result = solve_level(s, n, n > finest ? 0.03 * s->desc->tolerance : s->desc->tolerance);
  }
  return result;
}

/* Sweeps as long as there is time. */
static neph_result sweep_level(solver *s, unsigned number, unsigned sweeps) {
  if (!s->has_time || s->out->is_cut) return NEPH_OK;
  const neph_result result = np_transport_level_sweep(&s->fine->lights, &s->levels[number], sweeps, isfinite(s->end_s));
  if (np_monitor_is_cut(s->monitor)) end_budget(s);
  return result;
}

/* From what is iterated to the result. */
static neph_result resolve(solver *s) {
  const unsigned iterated = get_iterated(s);
  neph_result result = NEPH_OK;
  set_part(s, resolving_begin, is_fine(s) ? 0.5 * (resolving_begin + keeping_begin) : keeping_begin);
  if (is_resolved(s)) {
    np_transport_level_resolve(&s->fine->lights, &s->levels[iterated], &s->levels[iterated - 1]);
    result = sweep_level(s, iterated - 1, RESOLVING_SWEEPS);
  }
  if (!is_fine(s) || result) return result;
  set_part(s, 0.5 * (resolving_begin + keeping_begin), keeping_begin);
  result = prolong(s, 0);
  return result ? result : sweep_level(s, 0, REFINING_SWEEPS);
}

/* ---- Bands ---- */

static void clear_levels(solver *s) {
  for (unsigned n = 0; n < s->level_count; n++) np_transport_level_clear(&s->levels[n]);
  s->level_count = 0;
}

static neph_result add_coarser(solver *s) {
  const np_transport_grid *fine = &s->levels[s->level_count - 1].grid;
  return np_transport_grid_coarsen(fine, &s->levels[s->level_count++].grid);
}

static neph_result add_broad(solver *s) {
  const np_transport_grid *fine = &s->levels[s->level_count - 1].grid;
  np_transport_grid *broad = &s->levels[s->level_count++].grid;
  return np_transport_grid_reduce_degree(s->world, s->band, s->broad->ordinates.degree, fine, broad);
}

/* The grids for the present band's albedo, on the cells that were placed. */
static neph_result build_levels(solver *s) {
  clear_levels(s);
  np_transport_grid *finest = &s->levels[s->level_count++].grid;
  neph_result result = np_transport_grid_place(s->context, s->world, &s->desc->cells, finest);
  if (result) return result;
  finest->degree = s->fine->ordinates.degree;
  set_part(s, 0.0, 0.05);
  np_monitor_set_stage(s->monitor, "averaging clouds");
  result = np_transport_grid_fill(s->world, s->out->phases, s->band, s->monitor, finest);
  set_part(s, 0.05, solving_begin);
  np_monitor_set_stage(s->monitor, "lighting clouds");
  if (!result) result = np_transport_grid_light(s->world, s->monitor, s->band, s->broad->ordinates.degree, finest);
  if (!result && is_fine(s)) result = add_coarser(s);
  if (!result && is_resolved(s)) result = add_broad(s);
  while (!result && s->level_count < LEVELS_MAX && np_transport_grid_can_coarsen(&s->levels[s->level_count - 1].grid))
    result = add_coarser(s);
  for (unsigned n = 0; n < s->level_count && !result; n++)
    result = np_transport_level_allocate(&s->levels[n], s->world->emission);
  return result;
}

static neph_result find_sun(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const solver *s = user;
  const np_transport_grid *g = &s->levels[0].grid;
  for (size_t active = begin; active < end; active++)
    if (g->first_collision_source && g->first_collision_source[active] > 0.0f)
      s->sun[active] = np_world_sunlight(s->world, np_transport_grid_centre(g, g->cell[active]), s->world->to_sun);
  return NEPH_OK;
}

/* What glows in a cell is even, and has the moment j·∫Y₀₀ dΩ = j·√(4π). */
static neph_result average_glow(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const solver *s = user;
  const np_transport_level *finest = &s->levels[0];
  if (np_monitor_is_cancelled(s->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t active = begin; active < end; active++) {
    int32_t at[3];
    np_transport_grid_split(&finest->grid, finest->grid.cell[active], at);
    finest->glow[active] =
        sqrtf(4.0f * NP_PI_F) * np_transport_grid_average_emission(&finest->grid, s->world->emission, at, s->band);
  }
  return NEPH_OK;
}

/* Means over the cells of a level of what is known by those of the one before. */
static void restrict_level(const solver *s, unsigned to, const float *from, float *out) {
  const np_transport_grid *fine = &s->levels[to - 1].grid, *coarse = &s->levels[to].grid;
  if (is_resolved(s) && to == get_iterated(s)) {
    memcpy(out, from, fine->active_count * sizeof *out);
  } else {
    np_transport_grid_restrict(fine, from, coarse, out);
  }
}

static neph_result fill_glow(solver *s) {
  if (!s->world->emission) return NEPH_OK;
  neph_result result = np_parallel_for(s->context, s->monitor, s->levels[0].grid.active_count, 256, average_glow, s);
  for (unsigned n = 1; n < s->level_count && !result; n++)
    restrict_level(s, n, s->levels[n - 1].glow, s->levels[n].glow);
  return result;
}

/* First collisions times irradiance, of the finest cells. */
static void light_cells(const solver *s, const float *first_collision_source, float *out) {
  for (size_t active = 0; active < s->levels[0].grid.active_count; active++)
    out[active] = first_collision_source ? first_collision_source[active] * s->sun[active].band[s->band] : 0.0f;
}

/* Those in the medium that is iterated, where it is another than the result's. */
static neph_result light_broad(const solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  float *broad = s->levels[get_iterated(s)].sun;
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

/* Fills the levels' sources for the present band, and finds their sum, with what flows in. */
static neph_result light_levels(solver *s, double *out_sum) {
  const unsigned iterated = get_iterated(s);
  light_cells(s, s->levels[0].grid.first_collision_source, s->levels[0].sun);
  if (is_fine(s)) restrict_level(s, 1, s->levels[0].sun, s->levels[1].sun);
  neph_result result = is_resolved(s) ? light_broad(s) : NEPH_OK;
  if (result) return result;
  for (unsigned n = iterated + 1; n < s->level_count; n++) restrict_level(s, n, s->levels[n - 1].sun, s->levels[n].sun);
  s->fine->lights.boundary = s->fine->boundary[s->band];
  s->broad->lights.boundary = s->broad->boundary[s->band];

  const np_transport_level *level = &s->levels[iterated];
  *out_sum = 0.0;
  for (size_t active = 0; active < level->grid.active_count; active++)
    *out_sum += (double)level->sun[active] + (level->glow ? (double)level->glow[active] : 0.0);
  const float *boundary = &s->broad->boundary[s->band][0][0][0];
  for (size_t i = 0; i < sizeof s->broad->boundary[0] / sizeof(float); i++) *out_sum += (double)boundary[i];
  return NEPH_OK;
}

static size_t count_moments(const np_transport_grid *g) { return g->active_count * np_harmonics_count(g->degree); }

/* The start of a further band of grey clouds. */
static void scale_solution(solver *s, double factor) {
  np_transport_level *iterated = &s->levels[get_iterated(s)];
  for (size_t i = 0; i < count_moments(&iterated->grid); i++) iterated->phi[i] *= (float)factor;
}

/* Of values of which the largest are to be between 2¹⁴ and 2¹⁵: what loses bits then is four billionths of them. */
static float choose_scale(const float *values, size_t count) {
  float largest = 0.0f;
  for (size_t i = 0; i < count; i++) largest = fmaxf(largest, fabsf(values[i]));
  int exponent = 0;
  if (largest > 0.0f && isfinite(largest)) (void)frexpf(largest, &exponent);
  return ldexpf(1.0f, exponent > -110 ? exponent - 15 : -125);
}

/* Halves of a band's moments. */
typedef struct packing {
  const float *from;
  float inverse_scale;
  size_t count, stride; /* of a cell's moments, and from one cell to the next */
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

/* What is taken out where the march puts in what is exact: in means over cells, as the moments have it. */
static neph_result store_delta_m_residual(const solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  const size_t bands = s->out->band_count;
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
static neph_result keep_band(solver *s) {
  np_transport_level *finest = &s->levels[0];
  const size_t floats = count_moments(&finest->grid);
  const unsigned count = np_harmonics_count(finest->grid.degree);
  float *copy = NULL, *sharp = finest->phi;
  if (get_iterated(s) == 0) {
    sharp = copy = np_alloc(s->context, floats, sizeof *copy);
    if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
    memcpy(copy, finest->phi, floats * sizeof *copy);
  }
  neph_result result = np_transport_grid_sharpen(&finest->grid, count, s->monitor, sharp);
  if (s->out->importance && !result)
    np_importance_add(finest, sharp, 1.0f / (float)s->out->band_count, np_spectrum_max(s->world->sun_irradiance),
                      s->out->importance);
  const float scale = s->out->scale[s->band] = choose_scale(sharp, floats);
  packing p = {sharp, 1.0f / scale, count, (size_t)s->out->band_count * count,
               s->out->moments + (size_t)s->band * count};
  if (!result) result = np_parallel_for(s->context, s->monitor, finest->grid.active_count, CHUNK, pack, &p);
  np_alloc_free(s->context, copy);
  return result || !finest->grid.delta_m_residual ? result : store_delta_m_residual(s);
}

static neph_result solve_band(solver *s, bool is_first, double *sum) {
  const double before = *sum;
  neph_result result = fill_glow(s);
  if (!result) result = light_levels(s, sum);
  if (result || *sum <= 0.0) return result;
  set_part(s, solving_begin, 1.0);
  np_monitor_set_stage(s->monitor, "solving multiple scattering");
  /* A band of light that falls elsewhere is not well begun from one that was cut: it would keep that one's colour. */
  const bool is_nested = is_first || !(before > 0.0) || s->out->is_cut;
  begin_budget(s, is_nested);
  if (is_nested) {
    result = solve_nested(s);
  } else {
    scale_solution(s, *sum / before);
    if (s->has_time) result = solve_level(s, get_iterated(s), s->desc->tolerance);
  }
  if (!result) result = resolve(s);
  end_budget(s);
  set_part(s, keeping_begin, 1.0);
  return result ? result : keep_band(s);
}

/* Sums over what shines on the clouds, and whether all of it is the first band's times `colour`. */
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

/* Calls `visit` for the sun at each live cell and for what flows in along each ordinate. */
static void visit_lights(const solver *s, void (*visit)(light_colour *, const float *, size_t), light_colour *colour) {
  const size_t stride = sizeof s->fine->boundary[0] / sizeof(float);
  for (size_t active = 0; active < s->levels[0].grid.active_count; active++) visit(colour, s->sun[active].band, 1);
  for (size_t i = 0; i < stride; i++) visit(colour, &s->fine->boundary[0][0][0][0] + i, stride);
}

/* Where clouds are grey and their lights are of one colour, the first band's solution is all bands'. */
static void choose_bands(solver *s) {
  light_colour c = {.is_one = np_world_is_grey(s->world) && !s->world->emission, .colour = np_spectrum_grey(1.0f)};
  if (c.is_one) visit_lights(s, add_light, &c);
  c.is_one = c.is_one && c.sum[0] > 0.0;
  for (int b = 0; b < NP_BAND_COUNT && c.is_one; b++) c.colour.band[b] = (float)(c.sum[b] / c.sum[0]);
  if (c.is_one) visit_lights(s, check_light, &c);
  s->out->band_count = c.is_one ? 1 : NP_BAND_COUNT;
  s->out->colour = c.is_one ? c.colour : np_spectrum_grey(1.0f);
}

/* Where the first band's grid, on which the others' results must lie too, has cloud. */
static neph_result start_bands(solver *s) {
  const np_transport_grid *g = &s->levels[0].grid;
  s->sun = np_alloc(s->context, g->active_count, sizeof *s->sun);
  if (!s->sun) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(s->context, s->monitor, g->active_count, CHUNK, find_sun, s);
  if (result) return result;
  choose_bands(s);
  s->out->moments = np_alloc(s->context, count_moments(g), s->out->band_count * sizeof *s->out->moments);
  if (s->desc->has_importance) s->out->importance = np_alloc(s->context, g->active_count, sizeof *s->out->importance);
  if (g->delta_m_residual)
    s->out->delta_m_residual =
        np_alloc(s->context, g->active_count, s->out->band_count * sizeof *s->out->delta_m_residual);
  const bool has_all = s->out->moments && (s->out->importance || !s->desc->has_importance) &&
                       (s->out->delta_m_residual || !g->delta_m_residual);
  return has_all ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result solve_bands(solver *s) {
  const bool has_one_grid = np_world_is_grey(s->world);
  double sum = 0.0;
  s->out->band_count = NP_BAND_COUNT;
  for (s->band = 0; s->band < s->out->band_count; s->band++) {
    const bool is_first = s->band == 0 || !has_one_grid;
    neph_result result = is_first ? build_levels(s) : NEPH_OK;
    if (!result && s->band == 0) result = start_bands(s);
    if (!result) result = solve_band(s, is_first, &sum);
    if (result) return result;
  }
  if (s->out->importance) np_importance_spread(&s->levels[0].grid, s->out->importance);
  return NEPH_OK;
}

/* ---- All of it ---- */

static bool is_same_lobe(np_phase_lobe a, np_phase_lobe b) { return a.asymmetry == b.asymmetry && a.alpha == b.alpha; }

static bool is_same_phase(const np_phase *a, const np_phase *b) {
  return is_same_lobe(a->lobe[0], b->lobe[0]) && is_same_lobe(a->lobe[1], b->lobe[1]) && a->weight == b->weight &&
         a->table == b->table && a->table_weight == b->table_weight;
}

/* Equal phase functions share one table. */
static neph_result build_phases(const np_world *world, unsigned degree, np_scattering_field *out) {
  out->phases = np_alloc(out->context, world->clouds.count, sizeof *out->phases);
  if (!out->phases) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned v = 0; v < world->clouds.count; v++) {
    const np_phase *phase = &world->clouds.at[v].phase;
    unsigned same = 0;
    while (same < v && !is_same_phase(&out->phases[same].phase, phase)) same++;
    if (same < v) {
      out->phases[v] = out->phases[same];
    } else {
      neph_result result = np_scaled_phase_init(out->context, phase, degree, &out->phases[v]);
      if (result) return result;
    }
    out->volume_count = v + 1;
  }
  return NEPH_OK;
}

/* The highest degree, of those whose harmonics fill whole vectors, that the cells' number allows. */
static unsigned choose_degree(double cells, bool is_layered, double work_max) {
  static const unsigned degrees[] = {NP_DEGREE_MAX, 7};
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
    const double directions = np_ordinates_count(degrees[i], is_layered);
    if (cells * directions * np_harmonics_count(degrees[i]) <= work_max) return degrees[i];
  }
  return NP_DEGREE_MIN;
}

/* Bytes that a cell takes whose light is iterated in the least degree, and resolved into more. */
static double count_resolved_bytes(void) {
  return np_transport_count_iterated_bytes(NP_DEGREE_MIN) + np_transport_count_swept_bytes(RESOLVED_DEGREE);
}

/* The same of a fine one; those twice as wide are an eighth as many, and at the clouds' rim more. */
static double count_fine_bytes(void) {
  return np_transport_count_swept_bytes(RESOLVED_DEGREE) + 1.0 / 6.0 * count_resolved_bytes();
}

static double count_bytes_max(const np_transport_desc *cells) {
  return (double)cells->cell_count_max * np_transport_count_iterated_bytes(NP_DEGREE_MIN);
}

/* The degree that a solution of the least degree is resolved into, where the memory that so many cells of the least
 * degree could take is enough. */
static unsigned choose_resolved(double cells, bool is_fine_wanted, unsigned degree, const np_transport_desc *desc) {
  const double bytes = cells * (is_fine_wanted ? count_fine_bytes() : count_resolved_bytes());
  return degree == NP_DEGREE_MIN && bytes <= count_bytes_max(desc) ? RESOLVED_DEGREE : degree;
}

void np_scattering_desc_set_rays(np_scattering_desc *desc, double rays) {
  desc->cells.cell_count_fine = (size_t)fmin(cells_per_ray * rays, count_bytes_max(&desc->cells) / count_fine_bytes());
}

static neph_result start_angles(solver *s, unsigned degree, bool is_layered, angles **out) {
  *out = np_alloc(s->context, 1, sizeof **out);
  if (!*out) return NEPH_ERROR_OUT_OF_MEMORY;
  angles *a = *out;
  np_ordinates_init(degree, is_layered, &a->ordinates);
  np_boundary_radiance_fill(s->world, s->depths, &s->desc->cells, &a->ordinates, a->boundary);
  a->lights = (np_transport_lights){.context = s->context, .monitor = s->monitor, .ordinates = &a->ordinates};
  np_harmonics_eval(degree, np_vec3_scale(s->world->to_sun, -1.0f), a->lights.sun_harmonics);
  return NEPH_OK;
}

static neph_result start(solver *s) {
  np_transport_grid grid;
  neph_result result = np_transport_grid_place(s->context, s->world, &s->desc->cells, &grid);
  if (result) return result;
  const bool is_layered = grid.is_wrapped[0] || grid.is_wrapped[1], is_fine_wanted = grid.is_fine;
  const double cells = (double)np_transport_grid_count(&grid);
  np_transport_grid_clear(&grid);
  const unsigned degree = choose_degree(cells, is_layered, s->desc->work_max);
  const unsigned resolved = choose_resolved(cells, is_fine_wanted, degree, &s->desc->cells);
  result = start_angles(s, degree, is_layered, &s->broad);
  if (!result && resolved != degree) result = start_angles(s, resolved, is_layered, &s->fine);
  if (!s->fine) s->fine = s->broad;
  return result ? result : build_phases(s->world, resolved, s->out);
}

static void report(const np_world *world, double tolerance, np_scattering_field *out) {
  const np_transport_grid *g = &out->grid;
  double least, most;
  np_transport_grid_compute_depths(world, g, &least, &most);
  /* A column's cells are large only where light no longer changes over them. */
  out->error = np_transport_expect_error(np_transport_grid_is_column(g) ? least : most);
  np_log(out->context, NEPH_LOG_DEBUG,
         "multiple scattering: %d x %d x %d cells, %zu in cloud, degree %u, residual %.2g after %u sweeps", g->size[0],
         g->size[1], g->size[2], g->active_count, g->degree, out->residual, out->sweeps);
  np_log(out->context, NEPH_LOG_DEBUG,
         "multiple scattering: the densest cells have a scaled depth of %.2g to %.2g, for an expected error of %.2g %%",
         least, most, 100.0 * out->error);
  if (out->residual > 10.0 * tolerance && !out->is_cut)
    np_log(out->context, NEPH_LOG_WARNING, "multiple scattering has not converged: residual %.2g, wanted %.2g",
           out->residual, tolerance);
}

neph_result np_scattering_field_build(neph_context *context, const np_world *world, const np_sun_depth_source *depths,
                                      const np_scattering_desc *desc, np_monitor *monitor, np_scattering_field *out) {
  *out = (np_scattering_field){.context = context};
  solver s = {.context = context, .world = world, .depths = depths, .desc = desc, .monitor = monitor, .out = out};
  s.whole = np_monitor_get_part(monitor);
  s.end_s = isfinite(desc->seconds_max) ? np_monitor_get_seconds(monitor) + desc->seconds_max : HUGE_VAL;
  neph_result result = start(&s);
  if (!result) result = solve_bands(&s);
  if (!result) {
    out->grid = s.levels[0].grid;
    s.levels[0].grid = (np_transport_grid){.context = context};
    report(world, desc->tolerance, out);
  }
  clear_levels(&s);
  np_alloc_free(context, s.sun);
  if (s.fine != s.broad) np_alloc_free(context, s.fine);
  np_alloc_free(context, s.broad);
  if (result) np_scattering_field_clear(out);
  return result;
}

void np_scattering_field_clear(np_scattering_field *scatter) {
  for (unsigned v = 0; v < scatter->volume_count; v++) {
    bool is_shared = false;
    for (unsigned u = 0; u < v; u++) is_shared = is_shared || scatter->phases[u].peak == scatter->phases[v].peak;
    if (!is_shared) np_alloc_free(scatter->context, scatter->phases[v].peak);
  }
  np_alloc_free(scatter->context, scatter->phases);
  np_transport_grid_clear(&scatter->grid);
  np_alloc_free(scatter->context, scatter->moments);
  np_alloc_free(scatter->context, scatter->importance);
  np_alloc_free(scatter->context, scatter->delta_m_residual);
  *scatter = (np_scattering_field){0};
}
