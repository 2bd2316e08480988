/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture against look-ups of density: the march, and jittered exponential Euler with a fixed step.
 *
 * Usage: bench_march CLOUD.vdb UP DEPTH, with the axis of the file that is up (y or z) and the optical depth of its
 * densest column. Light scattered once, HG 0.85, from a sun of 60° in front and of 25° behind; one ray a pixel through
 * its middle, so that nothing but steps makes an error, which is the rms over all pixels, relative to the rms of the
 * picture.
 *
 * The truth is a march of eight midpoint steps a voxel, each lit through the exact integral of the trilinear field.
 *
 * The baseline goes through the cloud's box in steps of one length, shifted by one random number a ray, takes the
 * density at the middle of each, and marches towards the sun likewise from wherever it is not zero, in steps one, two
 * or four times as long, whichever is best. Both of its marches end where less than 0.1 % is left. It knows nothing of
 * what is empty; what it would need if it skipped empty bricks for nothing is printed beside. Not a test: it prints,
 * and the reader judges.
 */
#include <stdio.h>
#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "integrate/integrator.h"
#include "integrate/tracking.h"
#include "volume/volume_private.h"

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, POINTS_MAX = 64 };

void np_march_sample_counted(const np_scene_view *view, const np_integrator_settings *settings,
                             const np_camera_ray *ray, np_random *random, np_integrator_sample *out);

unsigned long bench_march_lookups;

typedef struct bench {
  neph_volume *volume;
  np_view_volume placed;
  np_scene_view view;
  np_camera_ray rays[PIXELS];
  double phase[PIXELS]; /* of the sun's light */
  double truth[PIXELS], rms;
} bench;

/* ---- The truth ---- */

static double find_exact_depth(const bench *b, np_dvec3 origin) {
  np_brick_walk walk;
  np_brick_span span;
  double depth = 0.0;
  np_track_start(&walk, &b->placed, origin, b->view.to_sun, 0.0, INFINITY);
  while (depth < 16.0 && np_brick_walk_next(&walk, &span))
    depth += (double)(b->placed.extinction_per_value * span.range.min) * (span.t_end - span.t_begin) +
             np_track_span_excess(&b->placed, &walk, &span);
  return depth;
}

static double find_truth(const bench *b, const np_camera_ray *ray) {
  np_brick_walk walk;
  np_brick_span span;
  double radiance = 0.0, depth = 0.0;
  np_track_start(&walk, &b->placed, ray->origin, ray->direction, 0.0, INFINITY);
  while (depth < 12.0 && np_brick_walk_next(&walk, &span)) {
    const int count = (int)ceil(8.0 * (span.t_end - span.t_begin));
    const double length = (span.t_end - span.t_begin) / count;
    for (int k = 0; k < count; k++) {
      const double middle = span.t_begin + length * (k + 0.5);
      const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, middle);
      const double added = (double)np_view_extinction(&b->placed, position) * length;
      if (added <= 0.0) continue;
      radiance -= exp(-depth) * expm1(-added) * exp(-find_exact_depth(b, position));
      depth += added;
    }
  }
  return radiance;
}

/* ---- The baseline ---- */

typedef struct euler {
  double step, light_step;
  unsigned long lookups, useful; /* all; those in bricks that are not empty */
} euler;

/* The part of a ray inside the cloud's box. */
static bool clip(const bench *b, np_dvec3 origin, np_vec3 direction, double *begin, double *end) {
  const double o[3] = {origin.x, origin.y, origin.z};
  const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  *begin = 0.0, *end = 1e30;
  for (int a = 0; a < 3; a++) {
    const double low = (b->volume->active_min[a] - 1.0 - o[a]) / d[a];
    const double high = (b->volume->active_max[a] + 1.0 - o[a]) / d[a];
    *begin = fmax(*begin, fmin(low, high));
    *end = fmin(*end, fmax(low, high));
  }
  return *begin < *end;
}

static double look_up(const bench *b, euler *e, np_dvec3 position) {
  int32_t cell[3];
  np_vec3 local;
  e->lookups++;
  if (!np_bricks_locate(b->placed.bricks, position, cell, &local)) return 0.0;
  e->useful += b->placed.bricks->ranges[0][np_bricks_get_offset(b->placed.bricks, 0, cell)].max > 0.0f;
  return (double)np_view_extinction(&b->placed, position);
}

static double find_euler_light(const bench *b, euler *e, np_dvec3 origin, double shift) {
  double begin, end, depth = 0.0;
  if (!clip(b, origin, b->view.to_sun, &begin, &end)) return 1.0;
  for (double t = shift * e->light_step; t < end && depth < 6.9; t += e->light_step)
    depth += e->light_step * look_up(b, e, np_dvec3_along(origin, b->view.to_sun, t));
  return exp(-depth);
}

static double march_euler(const bench *b, euler *e, const np_camera_ray *ray, np_random *random) {
  double begin, end, radiance = 0.0, transmittance = 1.0;
  const double shift = np_random_double(random);
  if (!clip(b, ray->origin, ray->direction, &begin, &end)) return 0.0;
  for (double t = begin + shift * e->step; t < end && transmittance > 1e-3; t += e->step) {
    const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, t);
    const double opacity = -expm1(-look_up(b, e, position) * e->step);
    if (opacity <= 0.0) continue;
    radiance += transmittance * opacity * find_euler_light(b, e, position, np_random_double(random));
    transmittance *= 1.0 - opacity;
  }
  return radiance;
}

/* ---- Measuring ---- */

/* What one picture took and how wrong it is. */
typedef struct point {
  double lookups, useful, error;
} point;

static point measure_euler(const bench *b, double step, double light_step) {
  euler e = {.step = step, .light_step = light_step};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  double sum = 0.0;
  for (int p = 0; p < PIXELS; p++) {
    const double d = b->phase[p] * march_euler(b, &e, &b->rays[p], &random) - b->truth[p];
    sum += d * d;
  }
  return (point){(double)e.lookups / PIXELS, (double)e.useful / PIXELS, sqrt(sum / PIXELS) / b->rms};
}

static point measure_march(const bench *b, float tolerance, float step_voxels) {
  const np_integrator_settings settings = {.scattering_max = 1,
                                           .look = {.octave_count = 1, .gain = 1.0f},
                                           .tolerance = tolerance,
                                           .step_voxels = step_voxels,
                                           .transmittance_end = 1e-3f};
  np_random random = np_random_start(2, 0, 0, 0, 0);
  double sum = 0.0;
  bench_march_lookups = 0;
  for (int p = 0; p < PIXELS; p++) {
    np_camera_ray ray = b->rays[p];
    np_integrator_sample sample;
    ray.jitter = np_random_float(&random);
    np_march_sample_counted(&b->view, &settings, &ray, &random, &sample);
    const double d = (double)sample.component[NP_COMPONENT_SUN].band[0] - b->truth[p];
    sum += d * d;
  }
  return (point){(double)bench_march_lookups / PIXELS, 0.0, sqrt(sum / PIXELS) / b->rms};
}

/* Of the baseline's points the fewest look-ups that have an error, between two points by a power law; NAN where none
 * gets there. */
static double find_lookups(const point *points, int count, double error, bool is_useful) {
  double best = NAN;
  for (int i = 0; i < count; i++)
    for (int k = 0; k < count; k++) {
      const point *good = &points[i], *bad = &points[k];
      if (good->error > error || bad->error < error) continue;
      const double t = good->error < bad->error ? log(bad->error / error) / log(bad->error / good->error) : 1.0;
      const double many = is_useful ? good->useful : good->lookups, few = is_useful ? bad->useful : bad->lookups;
      best = fmin(isnan(best) ? HUGE_VAL : best, few * pow(many / few, t));
    }
  return best;
}

static int measure_baseline(const bench *b, point points[POINTS_MAX]) {
  int count = 0;
  for (double step = 8.0; step > 0.2; step *= 0.5)
    for (double ratio = 1.0; ratio <= 4.0; ratio *= 2.0) {
      points[count] = measure_euler(b, step, step * ratio);
      printf("  Euler, steps of %5.3f, %5.3f to the sun   %9.0f look-ups   error %7.3f %%\n", step, step * ratio,
             points[count].lookups, 100.0 * points[count].error);
      count++;
    }
  return count;
}

static void print_march(const bench *b, const point *baseline, int count) {
  for (float tolerance = 0.2f; tolerance > 0.0005f; tolerance *= 0.5f) {
    const point p = measure_march(b, tolerance, 4.0f);
    printf("  march, tolerance %7.5f   %9.1f look-ups   error %7.3f %%   baseline %6.1f times as many, %6.1f without "
           "empty bricks\n",
           (double)tolerance, p.lookups, 100.0 * p.error, find_lookups(baseline, count, p.error, false) / p.lookups,
           find_lookups(baseline, count, p.error, true) / p.lookups);
  }
}

/* A pinhole on the side, looking level at the middle of the cloud's box, in voxels of 1 m. */
static void place_camera(bench *b, int up) {
  const int32_t *low = b->volume->active_min, *high = b->volume->active_max;
  const int side = up == 2 ? 1 : 2;
  const double middle[3] = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])};
  const double distance = 1.2 * (high[0] - low[0]),
               width = (high[side] - low[side]) / (distance - 0.25 * (high[0] - low[0]));
  for (int p = 0; p < PIXELS; p++) {
    double d[3] = {1.0, 0.0, 0.0};
    d[side] = width * ((p % WIDTH + 0.5) / WIDTH - 0.5) + 1e-4;
    d[up] = width * HEIGHT / WIDTH * ((p / WIDTH + 0.5) / HEIGHT - 0.5) + 1e-4;
    b->rays[p] = (np_camera_ray){.origin = {middle[0] - distance, middle[1], middle[2]},
                                 .direction = np_dvec3_to_float(np_dvec3_normalize(np_dvec3_make(d[0], d[1], d[2])))};
  }
}

static void run(bench *b, int up, double elevation_deg, double azimuth_deg) {
  const double elevation = elevation_deg * NP_DEGREE, azimuth = azimuth_deg * NP_DEGREE;
  double s[3] = {cos(elevation) * cos(azimuth)};
  s[3 - up] = cos(elevation) * sin(azimuth);
  s[up] = sin(elevation);
  b->view.to_sun = np_dvec3_to_float(np_dvec3_make(s[0], s[1], s[2]));
  double sum = 0.0;
  for (int p = 0; p < PIXELS; p++) {
    const np_vec3 d = b->rays[p].direction, to = b->view.to_sun;
    b->phase[p] = (double)np_phase_eval(&b->placed.phase, np_versine(d.x, d.y, d.z, to.x, to.y, to.z));
    b->truth[p] = b->phase[p] * find_truth(b, &b->rays[p]);
    sum += b->truth[p] * b->truth[p];
  }
  b->rms = sqrt(sum / PIXELS);
  printf("sun at %g degrees, %g from the line of sight; look-ups a pixel\n", elevation_deg, azimuth_deg);
  point baseline[POINTS_MAX];
  print_march(b, baseline, measure_baseline(b, baseline));
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
  if (count != 4) {
    fprintf(stderr, "usage: bench_march CLOUD.vdb UP DEPTH\n");
    return 2;
  }
  const int up = arguments[2][0] == 'y' ? 1 : 2;
  if (neph_context_create(&desc, &context) || neph_volume_load(context, arguments[1], NULL, &b.volume)) return 1;
  double column = 0.0;
  const np_affine upright = up == 1 ? (np_affine){{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}}} : np_affine_identity();
  if (np_volume_get_column_max(b.volume, &upright, NULL, &column)) return 1;
  b.placed = (np_view_volume){.bricks = &b.volume->bricks,
                              .world_to_index = np_affine_identity(),
                              .extinction_per_value = (float)(atof(arguments[3]) / column),
                              .albedo = np_spectrum_grey(1.0f),
                              .phase = np_phase_henyey_greenstein(0.85f)};
  b.view = (np_scene_view){.volume_count = 1, .volumes = &b.placed, .sun_irradiance = np_spectrum_grey(1.0f)};
  place_camera(&b, up);
  run(&b, up, 60.0, 130.0);
  run(&b, up, 25.0, 20.0);
  neph_volume_release(b.volume);
  neph_context_destroy(context);
  return 0;
}
