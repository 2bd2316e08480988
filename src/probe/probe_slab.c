/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs: a volume of 1×1×N samples, periodic in x and y, under a point sun or an even sky, with nothing around it. The
 * trilinear field rises from 0 at z = −1 and falls to 0 at z = N, and its column is the sum of the samples: so the
 * extinction depth/sum gives exactly the requested depth. That the field is not constant along z changes nothing: what
 * leaves a plane-parallel medium depends on optical depth alone. So samples are all 1 up to a depth of 1024, a
 * sixteenth of depth 1 each, and in thicker slabs, which would take too many of those, they grow from both faces
 * inwards.
 *
 * A flux is the integral of μ·L over the hemisphere, by camera rays that look at the face with the density q(μ) = ½ + μ
 * in μ: between even, which suits a thin slab (L ~ 1/μ), and cosine, which suits a thick one; no ray's weight exceeds
 * 4/3 of the best there is in either. They are spread by a low-discrepancy sequence, turned at random for each of 64
 * batches, whose means give the standard error. Light that has not been scattered is not looked for, but added in
 * closed form: e^{−τ/μ0}, or 2·E₃(τ) under an even sky.
 *
 * A standard error is only known where enough rays have met light: (Σ|x|)²/Σx² of them count, as many as there would be
 * of one brightness (Kish 1965, "Survey Sampling"). With 16, the least that are taken for enough, the error is a
 * quarter of the value; with fewer it is infinite: most of what there is they may not have met.
 */
#include "probe/probe_slab.h"

#include <assert.h>

#include "core/alloc.h"
#include "core/units.h"
#include "integrate/integrator.h"
#include "plan/integrator_choice.h"
#include "volume/volume_private.h"

enum { BATCH_COUNT = 64, SAMPLE_MIN = 64, SAMPLE_MAX = 16384 };

/* Number of rays of the first pilot, and the largest ratio of rays for which a pilot's prediction is trusted. */
enum { PILOT_RAY_COUNT = 4096, PILOT_TRUST = 8 };

/* Factor of the target error up to which a result is accepted; otherwise it is used as a pilot. */
static const double noise_allowed = 1.25;

/* Paths are guided where that takes less than this share of the time to the same error. Time is counted in random
 * numbers drawn, which no load on the machine changes; to a guided path each takes half as long again (44 to 63 ns for
 * 28 to 41, in slabs of depth 1 to 256). */
static const double guiding_share = 0.8, guided_draw_cost = 1.5;

/* First random stream of the pilots for that comparison, beyond the streams of all measurements. */
enum { GUIDING_PILOT_RUN = 1 << 30 };

struct np_slab {
  neph_context *context;
  np_slab_case case_;
  unsigned ray_count;
  double target_error; /* infinite: none */
  neph_path_guiding path_guiding;
  uint64_t seed;
  unsigned sample_count; /* along z */
  float extinction_per_value;
  neph_volume *volume;
  np_instance placed;
  np_world world;
  np_lighting lighting;
  np_scattering_field *scattering; /* the march's solution, which guides paths too */
  np_integrator_settings settings;
  np_integrator_fn integrate;
};

/* ---- The slab ---- */

static const double sample_depth = 1.0 / 16.0, sample_growth = 1.03;

/* Fills in the samples and sets their number; returns their sum. */
static double fill_samples(np_slab *slab, float values[SAMPLE_MAX]) {
  const double depth = slab->case_.depth;
  const bool is_even = depth <= SAMPLE_MAX * sample_depth;
  /* Sum of half a slab's geometric series: d·(qⁿ − 1)/(q − 1). */
  const double series = 1.0 + 0.5 * depth * (sample_growth - 1.0) / sample_depth;
  const double half = is_even ? fmax(0.5 * depth / sample_depth, 0.5 * SAMPLE_MIN) : log(series) / log(sample_growth);
  slab->sample_count = 2 * (unsigned)fmin(ceil(half), SAMPLE_MAX / 2);
  assert(slab->sample_count <= SAMPLE_MAX && slab->sample_count > 0);
  double sum = 0.0;
  for (unsigned i = 0; i < slab->sample_count; i++) {
    const unsigned from_top = slab->sample_count - 1 - i;
    values[i] = is_even ? 1.0f : (float)pow(sample_growth, i < from_top ? i : from_top);
    sum += (double)values[i];
  }
  return sum;
}

/* Creates voxels of 1 m height, so wide that only the most grazing rays reach a second column. */
static neph_result create_volume(np_slab *slab) {
  float values[SAMPLE_MAX];
  const double sum = fill_samples(slab, values);
  slab->extinction_per_value = (float)(slab->case_.depth / sum);
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.size[0] = desc.size[1] = 1;
  desc.size[2] = slab->sample_count;
  desc.values = values;
  desc.index_to_world[0][0] = desc.index_to_world[1][1] = 16.0 * slab->sample_count;
  desc.is_periodic_x = desc.is_periodic_y = true;
  desc.precision = NEPH_PRECISION_FLOAT;
  return neph_volume_create_dense(slab->context, &desc, &slab->volume);
}

static void fill_view(np_slab *slab) {
  const np_slab_case *c = &slab->case_;
  slab->placed = (np_instance){
      .bricks = &slab->volume->bricks,
      .world_to_index = slab->volume->world_to_index,
      .extinction_per_value = slab->extinction_per_value,
      .albedo = np_spectrum_grey((float)c->albedo),
      .phase = np_phase_henyey_greenstein((float)c->asymmetry),
  };
  slab->world = (np_world){.clouds.count = 1, .clouds.at = &slab->placed, .to_sun = {0.0f, 0.0f, 1.0f}};
  slab->lighting = (np_lighting){.sun_optical_depths.clouds = &slab->world.clouds};
  if (c->is_diffuse) {
    slab->world.environment_radiance = np_spectrum_grey((float)(1.0 / NP_PI));
    slab->world.is_environment_upper_only = true;
  } else {
    slab->world.to_sun = np_vec3_make(-(float)sqrt(1.0 - c->mu0 * c->mu0), 0.0f, (float)c->mu0);
    slab->world.sun_irradiance = np_spectrum_grey((float)(1.0 / c->mu0));
  }
}

/* Settings of a scene with all keys at their defaults. */
static neph_result choose_integrator(np_slab *slab, neph_integrator integrator) {
  neph_scene *scene;
  neph_result result = neph_scene_create(slab->context, &scene);
  if (result) return result;
  np_integrator_choice_make(&scene->render, scene->render.multiple_scattering, &slab->settings);
  neph_scene_destroy(scene);
  const np_integrator_kernels *kernels = np_integrator_get_kernels(neph_context_get_isa(slab->context));
  slab->integrate = integrator == NEPH_INTEGRATOR_PATH ? kernels->path : kernels->march;
  return NEPH_OK;
}

/* Whether light can be scattered at all. */
static bool has_light(const np_slab_case *c) { return c->depth > 0.0 && c->albedo > 0.0; }

/* Solves as a scene does at its defaults. */
static neph_result solve(np_slab *slab, bool has_importance) {
  np_scattering_desc desc = NP_SCATTERING_DESC_DEFAULT;
  desc.cells.bounds_min = np_dvec3_make(0.0, 0.0, -1.0);
  desc.cells.bounds_max = np_dvec3_make(1.0, 1.0, slab->sample_count);
  desc.has_importance = has_importance;
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&slab->lighting.sun_optical_depths);
  neph_result result = np_scattering_field_build(slab->context, &slab->world, &depths, &desc, NULL, &slab->scattering);
  slab->lighting.scattering = slab->scattering;
  return result;
}

neph_result np_slab_create(neph_context *context, const np_slab_case *case_, const neph_probe_desc *desc,
                           np_slab **out_slab) {
  *out_slab = NULL;
  np_slab *slab = np_alloc(context, 1, sizeof *slab);
  if (!slab) return NEPH_ERROR_OUT_OF_MEMORY;
  slab->context = context;
  slab->case_ = *case_;
  slab->ray_count = desc->path_count;
  slab->target_error = desc->target_error;
  slab->path_guiding = desc->integrator == NEPH_INTEGRATOR_PATH ? desc->path_guiding : NEPH_PATH_GUIDING_NONE;
  slab->seed = desc->seed;
  neph_result result = create_volume(slab);
  if (!result) result = choose_integrator(slab, desc->integrator);
  if (result) {
    np_slab_destroy(slab);
    return result;
  }
  fill_view(slab);
  const bool may_be_guided = slab->path_guiding != NEPH_PATH_GUIDING_NONE;
  if (has_light(case_) && (desc->integrator == NEPH_INTEGRATOR_MARCH || may_be_guided))
    result = solve(slab, may_be_guided);
  if (result) {
    np_slab_destroy(slab);
    return result;
  }
  *out_slab = slab;
  return NEPH_OK;
}

void np_slab_destroy(np_slab *slab) {
  if (!slab) return;
  np_scattering_field_destroy(slab->scattering);
  neph_volume_release(slab->volume);
  np_alloc_free(slab->context, slab);
}

/* ---- Questions ---- */

/* Sums of the rays of a batch. */
typedef struct batch {
  double mean, magnitudes, squares; /* mean and sum of squares of their radiances; sum of their magnitudes */
  uint64_t draws;
} batch;

typedef struct inquiry {
  const np_slab *slab;
  const np_slab_query *query;
  np_integrator_settings settings;
  uint32_t stream;
  uint32_t run; /* number of the run; runs before the last are pilots */
  unsigned rays_per_batch;
  np_monitor *monitor;
  batch batches[BATCH_COUNT];
} inquiry;

/* A ray that looks against light that leaves the face in the direction (μ, φ). */
static np_camera_ray make_ray(const np_slab *slab, bool is_top, double mu, double phi_rad, float jitter) {
  const double sine = sqrt(fmax(0.0, 1.0 - mu * mu)), sign = is_top ? 1.0 : -1.0;
  return (np_camera_ray){
      .origin = {0.0, 0.0, is_top ? slab->sample_count + 1.0 : -2.0},
      .direction = {-(float)(sine * cos(phi_rad)), -(float)(sine * sin(phi_rad)), -(float)(sign * mu)},
      .jitter = jitter,
  };
}

/* The μ below which q(μ) = ½ + μ has the share u. */
static double invert_share(double u) {
  assert(0.0 <= u && u <= 1.0);
  return 4.0 * u / (1.0 + sqrt(1.0 + 8.0 * u));
}

/* Low-discrepancy points of the plastic number. */
static double turn(double offset, double step, unsigned index) {
  const double x = offset + step * index;
  return x - floor(x);
}

/* Light scattered towards the camera; all bands are alike. */
static double measure_radiance(const inquiry *q, const np_camera_ray *ray, np_random *random) {
  np_integrator_sample sample;
  double radiance = 0.0;
  q->slab->integrate(&q->slab->world, &q->slab->lighting, &q->settings, ray, random, &sample);
  for (int c = 0; c < NP_COMPONENT_COUNT; c++)
    if (c != NP_COMPONENT_BACKGROUND) radiance += (double)sample.component[c].band[0];
  return radiance;
}

static double measure_ray(const inquiry *q, unsigned index, const double offset[2], np_random *random) {
  const np_slab_query *query = q->query;
  double mu = query->mu_view, phi_rad = query->phi_rad, weight = 1.0;
  if (query->is_flux) {
    mu = invert_share(turn(offset[0], 0.7548776662466927, index));
    phi_rad = 2.0 * NP_PI * turn(offset[1], 0.5698402909980532, index);
    weight = 2.0 * NP_PI * mu / (0.5 + mu);
  }
  const np_camera_ray ray = make_ray(q->slab, query->is_top, mu, phi_rad, np_random_float(random));
  return weight * measure_radiance(q, &ray, random);
}

static neph_result measure_batch(const inquiry *q, uint32_t number, batch *out) {
  const np_random start = np_random_start(q->slab->seed, q->stream, number, q->run, 0);
  np_random random = start;
  const double offset[2] = {np_random_double(&random), np_random_double(&random)};
  double sum = 0.0;
  *out = (batch){0};
  for (unsigned i = 0; i < q->rays_per_batch; i++) {
    if (np_monitor_is_cancelled(q->monitor)) return NEPH_ERROR_CANCELLED;
    const double radiance = measure_ray(q, i, offset, &random);
    sum += radiance;
    out->magnitudes += fabs(radiance);
    out->squares += radiance * radiance;
  }
  out->mean = sum / q->rays_per_batch;
  out->draws = np_random_count(&start, &random);
  return NEPH_OK;
}

static neph_result measure_batches(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  inquiry *q = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++) result = measure_batch(q, (uint32_t)i, &q->batches[i]);
  return result;
}

static np_slab_answer summarize(const batch batches[BATCH_COUNT]) {
  double sum = 0.0, squares = 0.0, magnitudes = 0.0, radiance_squares = 0.0;
  for (int i = 0; i < BATCH_COUNT; i++) {
    sum += batches[i].mean;
    magnitudes += batches[i].magnitudes;
    radiance_squares += batches[i].squares;
  }
  const double mean = sum / BATCH_COUNT;
  for (int i = 0; i < BATCH_COUNT; i++) squares += (batches[i].mean - mean) * (batches[i].mean - mean);
  return (np_slab_answer){.value = mean,
                          .error = sqrt(squares / BATCH_COUNT / (BATCH_COUNT - 1)),
                          .contributions = magnitudes > 0.0 ? magnitudes / radiance_squares * magnitudes : 0.0};
}

static neph_result measure(inquiry *q, unsigned ray_count, np_slab_answer *out_answer) {
  q->rays_per_batch = (ray_count - 1) / BATCH_COUNT + 1;
  neph_result result = np_parallel_for(q->slab->context, q->monitor, BATCH_COUNT, 1, measure_batches, q);
  if (!result) *out_answer = summarize(q->batches);
  return result;
}

/* Variance times time, by a pilot; infinite where it is not known. */
static neph_result predict_cost(inquiry *q, bool is_guided, unsigned ray_count, double *out_cost) {
  np_slab_answer pilot;
  q->settings.is_split = is_guided;
  q->run = GUIDING_PILOT_RUN + is_guided;
  neph_result result = measure(q, ray_count, &pilot);
  if (result) return result;
  double draws = 0.0;
  for (int i = 0; i < BATCH_COUNT; i++) draws += (double)q->batches[i].draws;
  const bool is_known = pilot.contributions >= NP_SLAB_CONTRIBUTIONS_MIN;
  *out_cost = is_known ? pilot.error * pilot.error * draws * (is_guided ? guided_draw_cost : 1.0) : HUGE_VAL;
  return NEPH_OK;
}

/* Whether paths are guided. What unguided ones hardly find needs no second pilot. */
static neph_result choose_guiding(inquiry *q) {
  q->settings.is_split = q->slab->path_guiding == NEPH_PATH_GUIDING_ADJOINT;
  if (q->slab->path_guiding != NEPH_PATH_GUIDING_AUTO) return NEPH_OK;
  const unsigned ray_count = (unsigned)fmin(PILOT_RAY_COUNT, ceil(0.25 * q->slab->ray_count));
  double unguided, guided = 0.0;
  neph_result result = predict_cost(q, false, ray_count, &unguided);
  if (!result && isfinite(unguided)) result = predict_cost(q, true, ray_count, &guided);
  q->settings.is_split = guided < guiding_share * unguided;
  q->run = 0;
  return result;
}

/* Number of rays for the target error, predicted by a pilot, plus a fifth: the pilot's error estimate is accurate to 10
 * % at best. */
static double count_rays(const np_slab_answer *pilot, double pilot_count, double target_error) {
  if (!(pilot->value > 0.0)) return HUGE_VAL;
  const double ratio = pilot->error / (pilot->value * target_error);
  return fmax(PILOT_RAY_COUNT, 1.2 * pilot_count * ratio * ratio);
}

static bool is_noisy(const np_slab_answer *answer, double target_error) {
  return answer->error > noise_allowed * target_error * answer->value;
}

/* Sends pilots to find how many rays are enough, and then as many. Where rare rays bring much, few rays know their own
 * error badly: so a pilot that forecasts far more than itself is followed by a larger one, and an answer that is
 * noisier than the target is but a pilot. Answers of pilots are not used, so that the number of rays is independent of
 * the answer; choosing a quiet one may bias it, where light and noise are correlated, by a part of its error. */
static neph_result measure_to_target(inquiry *q, double ray_count_max, np_slab_answer *out_answer) {
  const double target_error = q->slab->target_error;
  double count = fmin(PILOT_RAY_COUNT, ray_count_max);
  for (bool is_enough = count == ray_count_max;; q->run++) {
    neph_result result = measure(q, (unsigned)count, out_answer);
    if (result || (is_enough && (count == ray_count_max || !is_noisy(out_answer, target_error)))) return result;
    const double enough = fmin(ray_count_max, count_rays(out_answer, count, target_error));
    is_enough = enough <= PILOT_TRUST * count;
    count = is_enough ? enough : 2.0 * enough / PILOT_TRUST;
  }
}

/* E₃(x) = ∫₁^∞ e^{−xt}/t³ dt: by E₁'s series below 1, where the recurrence cancels little, and above by the continued
 * fraction e^{−x}/(x + 3 − 1·3/(x + 5 − 2·4/(x + 7 − …))) (Abramowitz and Stegun 1964, 5.1.11, 5.1.14, 5.1.22). */
static double compute_e3(double x) {
  if (x <= 0.0) return 0.5;
  if (x > 1.0) {
    double fraction = x + 203.0;
    for (int k = 100; k > 0; k--) fraction = x + 2.0 * k + 1.0 - k * (k + 2.0) / fraction;
    return exp(-x) / fraction;
  }
  double e1 = -0.57721566490153286 - log(x), term = 1.0;
  for (int k = 1; k < 25; k++) {
    term *= -x / k;
    e1 -= term / k;
  }
  return 0.5 * (exp(-x) * (1.0 - x) + x * x * e1);
}

static double compute_unscattered(const np_slab_case *c) {
  return c->is_diffuse ? 2.0 * compute_e3(c->depth) : exp(-c->depth / c->mu0);
}

static neph_result measure_scattered(inquiry *q, np_slab_answer *out_answer) {
  const np_slab *slab = q->slab;
  *out_answer = (np_slab_answer){.value = 0.0};
  if (!has_light(&slab->case_)) return NEPH_OK;
  neph_result result = choose_guiding(q);
  if (!result)
    result = isfinite(slab->target_error) ? measure_to_target(q, slab->ray_count, out_answer)
                                          : measure(q, slab->ray_count, out_answer);
  if (out_answer->contributions < NP_SLAB_CONTRIBUTIONS_MIN) out_answer->error = HUGE_VAL;
  return result;
}

neph_result np_slab_ask(const np_slab *slab, const np_slab_query *query, uint32_t stream, np_monitor *monitor,
                        np_slab_answer *out_answer) {
  inquiry q = {.slab = slab, .query = query, .settings = slab->settings, .stream = stream, .monitor = monitor};
  neph_result result = measure_scattered(&q, out_answer);
  if (!result && query->is_flux && !query->is_top) out_answer->value += compute_unscattered(&slab->case_);
  return result;
}
