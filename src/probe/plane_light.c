/* SPDX-License-Identifier: Apache-2.0 */
/* A flux is the integral of μ·L over the hemisphere, by rays against the light with the density ½ + μ in μ, as slabs
 * have it (probe_slab.c). Absorption is the integral of absorption times ∫ L dω over a layer. Places and directions
 * follow a low-discrepancy sequence in five dimensions, shifted at random for each of 64 batches, whose means give the
 * standard error of the whole. That of a column is the one of independent rays, which overstates it. */
#include "probe/plane_light.h"

#include "core/alloc.h"
#include "core/units.h"
#include "volume/tracking.h"

enum { DIMENSIONS = 5, PILOT_RAY_COUNT = 16384 };

/* Sums of a batch in a column. */
typedef struct tally {
  double sum[NP_BAND_COUNT], squares[NP_BAND_COUNT];
  unsigned count;
} tally;

typedef struct measurement {
  const np_plane_source *source;
  const np_plane_query *query;
  uint32_t stream, run;
  unsigned rays_per_batch;
  size_t column_count;
  np_monitor *monitor;
  tally *tallies; /* sums by column, batch after batch */
} measurement;

/* ---- Rays ---- */

/* Origin of a ray, and the direction of travel of the light along it. */
typedef struct plane_sample {
  np_dvec3 place;
  np_vec3 travel;
  double weight; /* factor on the radiance */
  size_t column;
} plane_sample;

/* Element `axis` of the index-th point, by powers of the root of x⁶ = x + 1 (Roberts 2018, "The Unreasonable
 * Effectiveness of Quasirandom Sequences"). */
static double get_point(const double shift[DIMENSIONS], unsigned index, int axis) {
  static const double steps[DIMENSIONS] = {0.88127146163357, 0.77663938908977, 0.68443012958534, 0.60316874068573,
                                           0.53155539771579};
  const double x = shift[axis] + steps[axis] * index;
  return x - floor(x);
}

/* The μ below which ½ + μ has the share u. */
static double invert_share(double u) { return 4.0 * u / (1.0 + sqrt(1.0 + 8.0 * u)); }

static np_vec3 make_direction(double mu, double phi_rad) {
  const double sine = sqrt(fmax(0.0, 1.0 - mu * mu));
  return np_vec3_make((float)(sine * cos(phi_rad)), (float)(sine * sin(phi_rad)), (float)mu);
}

static void set_direction(const np_plane_query *q, double u, double v, plane_sample *out) {
  const double phi_rad = 2.0 * NP_PI * v, mu = invert_share(u);
  out->travel = q->travel;
  out->weight = 1.0;
  if (q->kind == NP_PLANE_FLUX) {
    out->travel = make_direction(q->is_up ? mu : -mu, phi_rad);
    out->weight = 2.0 * NP_PI * mu / (0.5 + mu);
  } else if (q->kind == NP_PLANE_ABSORBED) {
    out->travel = make_direction(2.0 * u - 1.0, phi_rad);
    out->weight = 4.0 * NP_PI;
  }
}

static plane_sample make_sample(const measurement *m, const double shift[DIMENSIONS], unsigned index) {
  const np_plane_query *q = m->query;
  plane_sample out;
  double place[2];
  size_t cell[2];
  for (int a = 0; a < 2; a++) {
    const double u = get_point(shift, index, a);
    cell[a] = (size_t)fmin(u * q->columns[a], q->columns[a] - 1.0);
    place[a] = q->box_min_m[a] + u * (q->box_max_m[a] - q->box_min_m[a]);
  }
  const double height = q->kind == NP_PLANE_ABSORBED ? get_point(shift, index, 4) : 0.0;
  out.place = np_dvec3_make(place[0], place[1], q->low_m + height * (q->high_m - q->low_m));
  out.column = cell[1] * q->columns[0] + cell[0];
  set_direction(q, get_point(shift, index, 2), get_point(shift, index, 3), &out);
  return out;
}

/* ---- Light ---- */

static np_spectrum trace(const measurement *m, const plane_sample *at, np_random *random) {
  const np_plane_source *s = m->source;
  np_spectrum sum = np_spectrum_grey(0.0f);
  const np_camera_ray ray = {.origin = at->place,
                             .direction = np_vec3_scale(at->travel, -1.0f),
                             .jitter = np_random_float(random),
                             .choice = np_random_float(random)};
  for (unsigned v = 0; v < s->view_count; v++) {
    np_integrator_sample sample;
    s->integrate(s->views[v].world, s->views[v].lighting, &s->settings, &ray, random, &sample);
    sum = np_spectrum_add(sum, np_integrator_sum_light(&sample, NP_COMPONENTS_OF_BEAUTY));
  }
  return sum;
}

/* Unscattered light of sun and moon: irradiance of a level plane, or of a plane that faces them. */
static np_spectrum compute_direct(const measurement *m, np_dvec3 place, bool is_level, np_random *random) {
  static const double no_roulette = 700.0;
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned v = 0; v < m->source->view_count; v++) {
    const np_world *world = m->source->views[v].world;
    const float u = np_random_float(random), w = np_random_float(random);
    const np_vec3 to_sun = np_world_sample_sun(world, u, w);
    const np_spectrum light = np_world_sunlight_exact(world, place, to_sun);
    if (np_spectrum_is_zero(light)) continue;
    const float passed = np_track_transmittance(&world->clouds, place, to_sun, INFINITY, no_roulette, random);
    sum = np_spectrum_add_scaled(sum, passed * (is_level ? np_maxf(to_sun.z, 0.0f) : 1.0f), light);
  }
  return sum;
}

/* Absorption of the clouds at a place, 1/m. */
static np_spectrum compute_absorption(const np_instances *clouds, np_dvec3 place) {
  float extinction[NP_INSTANCES_MAX] = {0.0f};
  np_spectrum sum = np_spectrum_grey(0.0f);
  if (clouds->places) np_places_add_extinction(clouds->places, place, 1.0f, extinction);
  for (unsigned i = 0; i < clouds->count; i++) {
    if (!clouds->places) extinction[i] = np_instance_extinction(&clouds->at[i], place);
    sum =
        np_spectrum_add_scaled(sum, extinction[i], np_spectrum_subtract(np_spectrum_grey(1.0f), clouds->at[i].albedo));
  }
  return sum;
}

static np_spectrum measure_absorbed(const measurement *m, const plane_sample *at, np_random *random) {
  const np_spectrum absorption = compute_absorption(&m->source->views[0].world->clouds, at->place);
  if (np_spectrum_is_zero(absorption)) return absorption;
  const np_spectrum light =
      np_spectrum_add_scaled(compute_direct(m, at->place, false, random), (float)at->weight, trace(m, at, random));
  return np_spectrum_scale(np_spectrum_multiply(absorption, light), (float)(m->query->high_m - m->query->low_m));
}

static np_spectrum measure_sample(const measurement *m, const plane_sample *at, np_random *random) {
  if (m->query->kind == NP_PLANE_ABSORBED) return measure_absorbed(m, at, random);
  const np_spectrum scattered = np_spectrum_scale(trace(m, at, random), (float)at->weight);
  const bool has_direct = m->query->kind == NP_PLANE_FLUX && !m->query->is_up;
  return has_direct ? np_spectrum_add(scattered, compute_direct(m, at->place, true, random)) : scattered;
}

/* ---- Batches ---- */

static neph_result measure_batch(const measurement *m, uint32_t number) {
  np_random random = np_random_start(m->source->seed, m->stream, number, m->run, 0);
  tally *tallies = m->tallies + number * m->column_count;
  double shift[DIMENSIONS];
  for (int a = 0; a < DIMENSIONS; a++) shift[a] = np_random_double(&random);
  for (unsigned i = 0; i < m->rays_per_batch; i++) {
    if (np_monitor_is_cancelled(m->monitor)) return NEPH_ERROR_CANCELLED;
    const plane_sample at = make_sample(m, shift, i);
    const np_spectrum light = measure_sample(m, &at, &random);
    tally *t = &tallies[at.column];
    t->count++;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      t->sum[b] += (double)light.band[b];
      t->squares[b] += (double)light.band[b] * (double)light.band[b];
    }
  }
  return NEPH_OK;
}

static neph_result measure_batches(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++) result = measure_batch(user, (uint32_t)i);
  return result;
}

static np_plane_answer summarize_whole(const measurement *m) {
  np_plane_answer out = {{0}, {0}};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double means[NP_PLANE_BATCHES] = {0}, sum = 0.0, squares = 0.0;
    for (int i = 0; i < NP_PLANE_BATCHES; i++) {
      for (size_t c = 0; c < m->column_count; c++) means[i] += m->tallies[(size_t)i * m->column_count + c].sum[b];
      means[i] /= m->rays_per_batch;
      sum += means[i];
    }
    out.value[b] = sum / NP_PLANE_BATCHES;
    for (int i = 0; i < NP_PLANE_BATCHES; i++) squares += (means[i] - out.value[b]) * (means[i] - out.value[b]);
    out.error[b] = sqrt(squares / NP_PLANE_BATCHES / (NP_PLANE_BATCHES - 1));
  }
  return out;
}

/* The error of a column is infinite where fewer than two rays met it. */
static np_plane_answer summarize_column(const measurement *m, size_t column) {
  np_plane_answer out = {{0}, {0}};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (size_t i = 0; i < NP_PLANE_BATCHES; i++) {
      const tally *t = &m->tallies[i * m->column_count + column];
      sum += t->sum[b];
      squares += t->squares[b];
      count += t->count;
    }
    out.value[b] = count > 0.0 ? sum / count : 0.0;
    out.error[b] =
        count > 1.0 ? sqrt(fmax(squares / count - out.value[b] * out.value[b], 0.0) / (count - 1.0)) : HUGE_VAL;
  }
  return out;
}

neph_result np_plane_measure(const np_plane_source *source, const np_plane_query *query, unsigned ray_count,
                             uint32_t stream, uint32_t run, np_monitor *monitor, np_plane_answer *out_whole,
                             np_plane_answer *out_columns) {
  measurement m = {.source = source,
                   .query = query,
                   .stream = stream,
                   .run = run,
                   .rays_per_batch = (ray_count - 1) / NP_PLANE_BATCHES + 1,
                   .column_count = out_columns ? (size_t)query->columns[0] * query->columns[1] : 1,
                   .monitor = monitor};
  np_plane_query whole = *query;
  whole.columns[0] = whole.columns[1] = 1;
  if (!out_columns) m.query = &whole;
  m.tallies = np_alloc(source->context, NP_PLANE_BATCHES * m.column_count, sizeof *m.tallies);
  if (!m.tallies) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_parallel_for(source->context, monitor, NP_PLANE_BATCHES, 1, measure_batches, &m);
  if (!result) *out_whole = summarize_whole(&m);
  for (size_t c = 0; c < m.column_count && out_columns && !result; c++) out_columns[c] = summarize_column(&m, c);
  np_alloc_free(source->context, m.tallies);
  return result;
}

/* Rays for the target by a pilot: of the band whose error is the largest share. */
static double count_rays(const np_plane_answer *pilot, double pilot_count, double target_error) {
  double most = 0.0;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    if (!(pilot->value[b] > 0.0)) continue;
    const double ratio = pilot->error[b] / (pilot->value[b] * target_error);
    most = fmax(most, 1.2 * pilot_count * ratio * ratio);
  }
  return fmax(most, pilot_count);
}

neph_result np_plane_measure_to_target(const np_plane_source *source, const np_plane_query *query, double target_error,
                                       unsigned ray_count_max, uint32_t stream, np_monitor *monitor,
                                       unsigned *out_ray_count, np_plane_answer *out_whole,
                                       np_plane_answer *out_columns) {
  double count = ray_count_max;
  if (isfinite(target_error)) {
    const double pilot_count = fmin(PILOT_RAY_COUNT, ray_count_max);
    neph_result result = np_plane_measure(source, query, (unsigned)pilot_count, stream, 0, monitor, out_whole, NULL);
    if (result) return result;
    count = fmin(ray_count_max, count_rays(out_whole, pilot_count, target_error));
  }
  *out_ray_count = ((unsigned)count - 1) / NP_PLANE_BATCHES * NP_PLANE_BATCHES + NP_PLANE_BATCHES;
  return np_plane_measure(source, query, (unsigned)count, stream, 1, monitor, out_whole, out_columns);
}
