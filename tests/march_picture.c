/* SPDX-License-Identifier: Apache-2.0 */
#include "march_count.h"

#include "march_picture.h"

#include "core/units.h"
#include "volume/tracking.h"

unsigned long march_lookups;

/* ---- The reference ---- */

double march_compute_depth(const np_instance *cloud, np_dvec3 origin, np_vec3 direction) {
  np_brick_walk walk;
  np_brick_span span;
  double depth = 0.0;
  np_random unused = np_random_start(0, 0, 0, 0, 0); /* used for detail alone */
  np_track_start(&walk, cloud, origin, direction, 0.0, INFINITY);
  while (depth < 16.0 && np_brick_walk_next(&walk, &span))
    depth += (double)(cloud->extinction_per_value * span.range.min) * (span.t_end - span.t_begin) +
             np_track_span_excess(cloud, &walk, &span, INFINITY, &unused);
  return depth;
}

static double compute_reference(const march_picture *p, const np_camera_ray *ray) {
  np_brick_walk walk;
  np_brick_span span;
  double radiance = 0.0, depth = 0.0;
  np_track_start(&walk, &p->cloud, ray->origin, ray->direction, 0.0, INFINITY);
  while (depth < 12.0 && np_brick_walk_next(&walk, &span)) {
    const int count = (int)ceil(8.0 * (span.t_end - span.t_begin));
    const double length = (span.t_end - span.t_begin) / count;
    for (int k = 0; k < count; k++) {
      const double middle = span.t_begin + length * (k + 0.5);
      const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, middle);
      const double added = (double)np_instance_extinction(&p->cloud, position) * length;
      if (added <= 0.0) continue;
      radiance -= exp(-depth) * expm1(-added) * exp(-march_compute_depth(&p->cloud, position, p->world.to_sun));
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
static bool clip(const march_picture *p, np_dvec3 origin, np_vec3 direction, double *begin, double *end) {
  const double o[3] = {origin.x, origin.y, origin.z};
  const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  *begin = 0.0, *end = 1e30;
  for (int a = 0; a < 3; a++) {
    const double low = (p->low[a] - o[a]) / d[a];
    const double high = (p->high[a] - o[a]) / d[a];
    *begin = fmax(*begin, fmin(low, high));
    *end = fmin(*end, fmax(low, high));
  }
  return *begin < *end;
}

static double look_up(const march_picture *p, euler *e, np_dvec3 position) {
  int32_t cell[3];
  np_vec3 local;
  e->lookups++;
  if (!np_bricks_locate(p->cloud.bricks, position, cell, &local)) return 0.0;
  const np_brick_place at = np_bricks_get_place(p->cloud.bricks, cell);
  e->useful += np_bricks_get_range(p->cloud.bricks, &at, 0).max > 0.0f;
  return (double)np_instance_extinction(&p->cloud, position);
}

static double compute_euler_light(const march_picture *p, euler *e, np_dvec3 origin, double shift) {
  double begin, end, depth = 0.0;
  if (!clip(p, origin, p->world.to_sun, &begin, &end)) return 1.0;
  for (double t = shift * e->light_step; t < end && depth < 6.9; t += e->light_step)
    depth += e->light_step * look_up(p, e, np_dvec3_along(origin, p->world.to_sun, t));
  return exp(-depth);
}

static double march_euler(const march_picture *p, euler *e, const np_camera_ray *ray, np_random *random) {
  double begin, end, radiance = 0.0, transmittance = 1.0;
  const double shift = np_random_double(random);
  if (!clip(p, ray->origin, ray->direction, &begin, &end)) return 0.0;
  for (double t = begin + shift * e->step; t < end && transmittance > 1e-3; t += e->step) {
    const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, t);
    const double opacity = -expm1(-look_up(p, e, position) * e->step);
    if (opacity <= 0.0) continue;
    radiance += transmittance * opacity * compute_euler_light(p, e, position, np_random_double(random));
    transmittance *= 1.0 - opacity;
  }
  return radiance;
}

/* ---- Measuring ---- */

march_point march_picture_measure_euler(const march_picture *p, double step, double light_step) {
  const unsigned pixels = p->width * p->height;
  euler e = {.step = step, .light_step = light_step};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  double sum = 0.0;
  for (unsigned i = 0; i < pixels; i++) {
    const double d = p->phase[i] * march_euler(p, &e, &p->rays[i], &random) - p->reference[i];
    sum += d * d;
  }
  return (march_point){(double)e.lookups / pixels, (double)e.useful / pixels, sqrt(sum / pixels) / p->rms};
}

/* A few pixels that survive the roulette make a tenth of the error of so few: they are rendered often enough that it
 * does not depend on the numbers drawn. */
enum { PASSES = 16 };

march_point march_picture_measure(const march_picture *p, float tolerance) {
  const np_integrator_settings settings = {.scattering_max = 1,
                                           .approximation.gain = 1.0,
                                           .tolerance = tolerance,
                                           .step_voxels = 4.0f,
                                           .transmittance_end = 1e-3f};
  const unsigned pixels = p->width * p->height;
  np_random random = np_random_start(2, 0, 0, 0, 0);
  double sum = 0.0;
  march_lookups = 0;
  for (unsigned n = 0; n < PASSES * pixels; n++) {
    const unsigned i = n % pixels;
    np_camera_ray ray = p->rays[i];
    np_integrator_sample sample;
    ray.jitter = np_random_float(&random);
    np_march_sample_counted(&p->world, &p->lighting, &settings, &ray, &random, &sample);
    const double d = (double)sample.component[NP_COMPONENT_SUN].band[0] - p->reference[i];
    sum += d * d;
  }
  return (march_point){(double)march_lookups / (PASSES * pixels), 0.0, sqrt(sum / (PASSES * pixels)) / p->rms};
}

double march_points_compute_lookups(const march_point *points, int count, double error, bool is_useful) {
  double best = NAN;
  for (int i = 0; i < count; i++)
    for (int k = 0; k < count; k++) {
      const march_point *good = &points[i], *bad = &points[k];
      if (good->error > error || bad->error < error) continue;
      const double t = good->error < bad->error ? log(bad->error / error) / log(bad->error / good->error) : 1.0;
      const double many = is_useful ? good->useful : good->lookups, few = is_useful ? bad->useful : bad->lookups;
      best = fmin(isnan(best) ? HUGE_VAL : best, few * pow(many / few, t));
    }
  return best;
}

void march_picture_init(march_picture *p, const np_bricks *bricks, float extinction_per_value) {
  *p = (march_picture){.cloud = {.bricks = bricks,
                                 .world_to_index = np_affine_identity(),
                                 .extinction_per_value = extinction_per_value,
                                 .albedo = np_spectrum_grey(1.0f),
                                 .phase = np_phase_henyey_greenstein(0.85f)},
                       .world = {.clouds = {1, &p->cloud}, .sun_irradiance = np_spectrum_grey(1.0f)},
                       .lighting.sun_optical_depths.clouds = &p->world.clouds};
}

/* A pinhole on the side, looking level at the middle of the cloud's box. */
static void place_camera(march_picture *p) {
  const int side = 3 - p->up;
  const double length = p->high[0] - p->low[0], distance = 1.2 * length;
  const double width = (p->high[side] - p->low[side]) / (distance - 0.25 * length),
               height = width * p->height / p->width;
  const np_dvec3 origin = {0.5 * (p->low[0] + p->high[0]) - distance, 0.5 * (p->low[1] + p->high[1]),
                           0.5 * (p->low[2] + p->high[2])};
  for (unsigned i = 0; i < p->width * p->height; i++) {
    double d[3] = {1.0, 0.0, 0.0};
    d[side] = width * ((i % p->width + 0.5) / p->width - 0.5) + 1e-4;
    d[p->up] = height * ((i / p->width + 0.5) / p->height - 0.5) + 1e-4;
    p->rays[i] = (np_camera_ray){.origin = origin,
                                 .direction = np_dvec3_to_float(np_dvec3_normalize(np_dvec3_make(d[0], d[1], d[2])))};
  }
}

void march_picture_light(march_picture *p, double elevation_rad, double azimuth_rad) {
  double s[3] = {cos(elevation_rad) * cos(azimuth_rad)}, sum = 0.0;
  s[3 - p->up] = cos(elevation_rad) * sin(azimuth_rad);
  s[p->up] = sin(elevation_rad);
  p->world.to_sun = np_dvec3_to_float(np_dvec3_make(s[0], s[1], s[2]));
  place_camera(p);
  const unsigned pixels = p->width * p->height;
  for (unsigned i = 0; i < pixels; i++) {
    const np_vec3 d = p->rays[i].direction, to = p->world.to_sun;
    p->phase[i] = (double)np_phase_eval(&p->cloud.phase, np_vec3_versine(d, to));
    p->reference[i] = p->phase[i] * compute_reference(p, &p->rays[i]);
    sum += p->reference[i] * p->reference[i];
  }
  p->rms = sqrt(sum / pixels);
}
