/* SPDX-License-Identifier: Apache-2.0 */
/* Estimators of the transmittance along shadow rays: mean square error times time, at equal majorants.
 *
 * Usage: bench_transmittance CLOUD.vdb. Rays start where light scatters, at points of the cloud drawn in proportion to
 * its density, and go to a sun at 60° and at 4°; the densest vertical column has the optical depth printed. The
 * reference is the integral of the trilinear field, a cubic between voxel faces, by two Gauss points for each: exact.
 * Not a test: it prints, and the reader judges.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "volume/tracking.h"
#include "volume/volume_private.h"

enum { RAYS = 2000, ESTIMATES = 32 };

typedef struct bench {
  neph_volume *volume;
  np_instance placed;
  np_instances clouds;
  float *brick_mean;
  np_vec3 to_sun;
  np_dvec3 origin[RAYS];
  double reference[RAYS];
} bench;

typedef double (*estimator_fn)(const bench *b, np_dvec3 origin, np_random *random);

static double look_up(const bench *b, const np_brick_walk *walk, const np_brick_span *span, double t) {
  const float value = span->brick == NP_BRICK_NONE
                          ? span->range.min
                          : np_brick_sample(b->placed.bricks, span->brick, np_brick_walk_local(walk, span, t));
  return (double)(b->placed.extinction_per_value * value);
}

/* ---- Tracking ---- */

static double estimate_delta(const bench *b, np_dvec3 origin, np_random *random) {
  const np_instance *volume;
  np_flight flight = np_flight_start(np_track_flight(random), 0.0);
  return isinf(np_track_collision(&b->clouds, origin, b->to_sun, INFINITY, &flight, random, &volume));
}

static double estimate_tracer(const bench *b, np_dvec3 origin, np_random *random) {
  return (double)np_track_transmittance(&b->clouds, origin, b->to_sun, INFINITY, np_track_faint_depth, random);
}

/* Residual ratio tracking with a control that a callback chooses for each cell. */
typedef struct control {
  double extinction, residual; /* 1/m; bound of |σ − control| */
} control;

static control choose_none(const bench *b, const np_brick_span *span) {
  return (control){0.0, (double)(b->placed.extinction_per_value * span->range.max)};
}

static control choose_minimum(const bench *b, const np_brick_span *span) {
  return (control){(double)(b->placed.extinction_per_value * span->range.min),
                   (double)(b->placed.extinction_per_value * (span->range.max - span->range.min))};
}

static control choose_mean(const bench *b, const np_brick_span *span) {
  const float mean = span->brick == NP_BRICK_NONE ? span->range.min : b->brick_mean[span->brick];
  const float residual = fmaxf(span->range.max - mean, mean - span->range.min);
  return (control){(double)(b->placed.extinction_per_value * mean),
                   (double)(b->placed.extinction_per_value * residual)};
}

static double estimate_residual(const bench *b, np_dvec3 origin, np_random *random,
                                control (*choose)(const bench *, const np_brick_span *)) {
  np_brick_walk walk;
  np_brick_span span;
  double depth = 0.0, weight = 1.0, flight = np_track_flight(random);
  np_track_start(&walk, &b->placed, origin, b->to_sun, 0.0, INFINITY);
  while (np_brick_walk_next(&walk, &span)) {
    const control c = choose(b, &span);
    depth += c.extinction * (span.t_end - span.t_begin);
    double t = span.t_begin;
    while (flight < c.residual * (span.t_end - t)) {
      t += flight / c.residual;
      weight *= 1.0 - (look_up(b, &walk, &span, t) - c.extinction) / c.residual;
      flight = np_track_flight(random);
    }
    flight -= c.residual * (span.t_end - t);
    /* The same roulette as the tracer's, with the sign kept. */
    const double size = fabs(weight) * exp(-depth);
    if (size >= 0.1) continue;
    if (np_random_double(random) >= size) return 0.0;
    weight = copysign(1.0, weight);
    depth = 0.0;
  }
  return weight * exp(-depth);
}

static double estimate_ratio(const bench *b, np_dvec3 origin, np_random *random) {
  return estimate_residual(b, origin, random, choose_none);
}

static double estimate_residual_minimum(const bench *b, np_dvec3 origin, np_random *random) {
  return estimate_residual(b, origin, random, choose_minimum);
}

static double estimate_residual_mean(const bench *b, np_dvec3 origin, np_random *random) {
  return estimate_residual(b, origin, random, choose_mean);
}

/* ---- Unbiased ray marching (Kettunen, d'Eon, Pantaleoni and Novák 2021) ---- */

enum { ORDER_MAX = 32 };

/* Minus the optical depth by a comb of `step` m, shifted at random, over all that is not empty. */
static double estimate_exponent(const bench *b, np_dvec3 origin, double step, double shift) {
  np_brick_walk walk;
  np_brick_span span;
  double sum = 0.0;
  np_track_start(&walk, &b->placed, origin, b->to_sun, 0.0, INFINITY);
  while (np_brick_walk_next(&walk, &span))
    for (double k = ceil(span.t_begin / step - shift); (k + shift) * step < span.t_end; k += 1.0)
      sum += look_up(b, &walk, &span, (k + shift) * step);
  return -sum * step;
}

/* Mean over the choices of k out of n of the products of what is chosen: elementary symmetric polynomial by binomial.
 */
static void fill_symmetric_means(const double *x, int count, double out[ORDER_MAX]) {
  out[0] = 1.0;
  for (int k = 1; k <= count; k++) out[k] = 0.0;
  for (int n = 0; n < count; n++)
    for (int k = n + 1; k > 0; k--) out[k] += x[n] * out[k - 1];
  double binomial = 1.0;
  for (int k = 1; k <= count; k++) {
    binomial *= (double)(count - k + 1) / k;
    out[k] /= binomial;
  }
}

/* Order of the power series: 0 or 1 for certain, further ones by roulette (the paper's BK roulette with K = 2). */
static int draw_order(np_random *random, double inverse_chance[ORDER_MAX]) {
  int order = 0;
  double chance = 1.0;
  inverse_chance[0] = 1.0;
  while (order + 1 < ORDER_MAX) {
    const double go_on = order < 1 ? 0.9 : fmin(1.0, 2.0 / (order + 1.0));
    if (np_random_double(random) >= go_on) break;
    chance *= go_on;
    inverse_chance[++order] = 1.0 / chance;
  }
  return order;
}

static double estimate_unbiased_march_by(const bench *b, np_dvec3 origin, double step, np_random *random) {
  double inverse_chance[ORDER_MAX], exponent[ORDER_MAX + 1], others[ORDER_MAX], means[ORDER_MAX + 1];
  const int order = draw_order(random, inverse_chance);
  for (int i = 0; i <= order; i++) exponent[i] = estimate_exponent(b, origin, step, np_random_double(random));
  double sum = 0.0;
  for (int pivot = 0; pivot <= order; pivot++) {
    int count = 0;
    for (int i = 0; i <= order; i++)
      if (i != pivot) others[count++] = exponent[i] - exponent[pivot];
    fill_symmetric_means(others, count, means);
    double series = 0.0, factorial = 1.0;
    for (int k = 0; k <= order; k++) {
      factorial *= k > 0 ? k : 1;
      series += means[k] * inverse_chance[k] / factorial;
    }
    sum += exp(exponent[pivot]) * series;
  }
  return sum / (order + 1);
}

/* Steps of whole voxels, edge 1 m here. */
static double estimate_unbiased_march_1(const bench *b, np_dvec3 origin, np_random *random) {
  return estimate_unbiased_march_by(b, origin, 1.0, random);
}
static double estimate_unbiased_march_4(const bench *b, np_dvec3 origin, np_random *random) {
  return estimate_unbiased_march_by(b, origin, 4.0, random);
}

/* ---- The reference, which is also an estimator ---- */

/* Distance to the next face between samples that the ray crosses, after t and before t_end. */
static double compute_next_face(const np_brick_walk *walk, double t, double t_end) {
  for (int a = 0; a < 3; a++) {
    if (walk->inverse[a] == 0.0) continue;
    const double position = walk->origin[a] + (t + 1e-9) * walk->direction[a];
    const double face = walk->inverse[a] > 0.0 ? floor(position) + 1.0 : ceil(position) - 1.0;
    t_end = fmin(t_end, fmax((face - walk->origin[a]) * walk->inverse[a], t + 1e-9));
  }
  return t_end;
}

static double compute_exact(const bench *b, np_dvec3 origin, np_random *random) {
  (void)random;
  np_brick_walk walk;
  np_brick_span span;
  double depth = 0.0;
  np_track_start(&walk, &b->placed, origin, b->to_sun, 0.0, INFINITY);
  while (np_brick_walk_next(&walk, &span))
    for (double t = span.t_begin, next; t < span.t_end; t = next) {
      next = span.brick == NP_BRICK_NONE ? span.t_end : compute_next_face(&walk, t, span.t_end);
      const double middle = 0.5 * (t + next), offset = (next - t) * 0.28867513459481288;
      depth +=
          0.5 * (next - t) * (look_up(b, &walk, &span, middle - offset) + look_up(b, &walk, &span, middle + offset));
    }
  return exp(-depth);
}

/* ---- Measuring ---- */

/* Seconds of this thread's processor time, so that a busy machine disturbs less. */
static double read_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct figure {
  double mse, bias, ns;
} figure;

static figure measure(const bench *b, estimator_fn estimate) {
  figure f = {0};
  np_random random = np_random_start(2, 0, 0, 0, 0);
  const double begin = read_seconds();
  for (int ray = 0; ray < RAYS; ray++)
    for (int k = 0; k < ESTIMATES; k++) {
      const double error = estimate(b, b->origin[ray], &random) - b->reference[ray];
      f.mse += error * error / ((double)RAYS * ESTIMATES);
      f.bias += error / ((double)RAYS * ESTIMATES);
    }
  f.ns = (read_seconds() - begin) * 1e9 / ((double)RAYS * ESTIMATES);
  return f;
}

static void print_estimators(const bench *b) {
  static const struct {
    const char *name;
    estimator_fn estimate;
  } rows[] = {{"ratio tracking", estimate_ratio},
              {"delta tracking", estimate_delta},
              {"residual, cell's minimum", estimate_residual_minimum},
              {"residual, cell's mean", estimate_residual_mean},
              {"unbiased march, comb of 1 voxel", estimate_unbiased_march_1},
              {"unbiased march, comb of 4 voxels", estimate_unbiased_march_4},
              {"exact, voxel by voxel", compute_exact},
              {"exact, faint rays by roulette (tracer)", estimate_tracer}};
  double reference = 0.0;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const figure f = measure(b, rows[i].estimate);
    if (i == 0) reference = f.mse * f.ns;
    printf("  %-38s MSE %.3e  bias %+.1e  %7.0f ns  gain over ratio %6.2f\n", rows[i].name, f.mse, f.bias, f.ns,
           reference / (f.mse * f.ns));
  }
}

static void draw_origins(bench *b) {
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int ray = 0; ray < RAYS;) {
    double position[3];
    for (int a = 0; a < 3; a++)
      position[a] =
          b->volume->active_min[a] + (b->volume->active_max[a] - b->volume->active_min[a]) * np_random_double(&random);
    const np_dvec3 p = np_dvec3_make(position[0], position[1], position[2]);
    if (np_bricks_sample(b->placed.bricks, p) > np_random_float(&random) * b->volume->value_max) b->origin[ray++] = p;
  }
}

/* Index space is the world, with voxels of 1 m; y is up in the file. */
static void run(bench *b, double depth, double elevation_deg) {
  double column = 0.0;
  const np_affine up = {{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}}};
  if (np_volume_get_column_max(b->volume, &up, NULL, &column)) exit(1);
  b->placed = (np_instance){.bricks = &b->volume->bricks,
                            .world_to_index = np_affine_identity(),
                            .extinction_per_value = (float)(depth / column)};
  b->clouds = (np_instances){.count = 1, .at = &b->placed};
  const double elevation = elevation_deg * NP_DEGREE;
  b->to_sun = np_vec3_make((float)(0.6 * cos(elevation)), (float)sin(elevation), (float)(0.8 * cos(elevation)));
  draw_origins(b);
  double mean = 0.0;
  for (int ray = 0; ray < RAYS; ray++) mean += (b->reference[ray] = compute_exact(b, b->origin[ray], NULL)) / RAYS;
  printf("optical depth %g, sun at %g deg: mean transmittance %.4f\n", depth, elevation_deg, mean);
  print_estimators(b);
}

static void compute_brick_means(bench *b) {
  const np_bricks *bricks = &b->volume->bricks;
  b->brick_mean = calloc(bricks->brick_count, sizeof *b->brick_mean);
  if (!b->brick_mean) exit(1);
  for (size_t brick = 0; brick < bricks->brick_count; brick++)
    for (int n = 0; n < 512; n++) {
      const np_vec3 middle = np_vec3_make((float)(n >> 6) + 0.5f, (float)(n >> 3 & 7) + 0.5f, (float)(n & 7) + 0.5f);
      b->brick_mean[brick] += np_brick_sample(bricks, (uint32_t)brick, middle) / 512.0f;
    }
}

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  fprintf(stderr, "%s\n", message);
}

int main(int count, char **arguments) {
  static bench b;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  desc.log = print_message;
  if (count != 2) {
    fprintf(stderr, "usage: bench_transmittance CLOUD.vdb\n");
    return 2;
  }
  if (neph_context_create(&desc, &context) || neph_volume_load(context, arguments[1], NULL, &b.volume)) return 1;
  compute_brick_means(&b);
  run(&b, 40.0, 60.0);
  run(&b, 40.0, 4.0);
  run(&b, 150.0, 60.0);
  run(&b, 4.0, 60.0);
  free(b.brick_mean);
  neph_volume_release(b.volume);
  neph_context_destroy(context);
  return 0;
}
