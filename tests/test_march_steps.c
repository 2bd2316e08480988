/* SPDX-License-Identifier: Apache-2.0 */
/* Steps of the march: thin sheets are found, errors follow the tolerance, and look-ups are few. */
#include "march_count.h"

#include "march_picture.h"

#include "test_world.h"

enum { EDGE = 72 };

/* EDGE³ samples at whole metres from (0, 0, 0) on. */
static void start(test_world *w, test_field field, float extinction_per_m) {
  test_cloud cloud = test_cloud_make(field, extinction_per_m, np_phase_isotropic());
  const double middle = 0.5 * (EDGE - 1);
  cloud.edge = EDGE;
  cloud.middle_m = np_dvec3_make(middle, middle, middle);
  test_world_create(w, 1, cloud);
  w->world.sun_irradiance = np_spectrum_grey(4.0f * NP_PI_F);
  w->settings.scattering_max = 1;
  w->settings.tolerance = 0.02f;
  w->settings.transmittance_end = 1e-3f;
}

static np_vec3 draw_direction(np_random *random) {
  const double z = 2.0 * np_random_double(random) - 1.0, azimuth = 2.0 * NP_PI * np_random_double(random);
  const double r = sqrt(1.0 - z * z);
  return np_dvec3_to_float(np_dvec3_make(r * cos(azimuth), r * sin(azimuth), z));
}

/* A ray of any direction through a place of the volume's inner half, from 200 m before it. */
static np_camera_ray draw_ray(np_random *random) {
  const np_vec3 direction = draw_direction(random);
  const double quarter = 0.25 * EDGE;
  const np_dvec3 place = np_dvec3_make(quarter + 2.0 * quarter * np_random_double(random),
                                       quarter + 2.0 * quarter * np_random_double(random),
                                       quarter + 2.0 * quarter * np_random_double(random));
  return (np_camera_ray){
      .origin = np_dvec3_along(place, direction, -200.0), .direction = direction, .jitter = np_random_float(random)};
}

/* ---- Thin sheets ---- */

static float sheet_level(double x, double y, double z) {
  (void)x, (void)y;
  return z == 1.5 ? 1.0f : 0.0f;
}

/* Thinner than a voxel: the samples of a tent of that width, whose slope no axis has. */
static float sheet_tilted(double x, double y, double z) {
  const double distance = 0.48 * (x - 0.5) + 0.36 * (y - 0.5) + 0.8 * (z - 0.5);
  return (float)fmax(0.0, 1.0 - fabs(distance));
}

static float sheet_in_haze(double x, double y, double z) {
  return z == 1.5 ? 1.0f : 0.002f + 0.001f * sinf((float)(x + y + EDGE - 1));
}

/* Every ray finds the sheet, whatever its angle: its transmittance is that of the field's integral. Half the tolerance
 * is the rms error that the march promises of a ray's opacity, or of the sheet's from straight ahead, for rays that
 * only graze an edge; single rays, of some thousands, may be six times that off. */
static void check_sheet(test_field field, float extinction_per_m) {
  test_world w;
  start(&w, field, extinction_per_m);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  double sum = 0.0, tolerance = (double)w.settings.tolerance;
  int count = 0;
  for (int i = 0; i < 4000; i++) {
    const np_camera_ray ray = draw_ray(&random);
    np_integrator_sample sample;
    test_world_march(&w, &ray, &random, &sample);
    const double opacity = -expm1(-march_compute_depth(&w.placed[0], ray.origin, ray.direction));
    const double found = 1.0 - (double)sample.transmittance;
    const double scale = fmax(opacity, -expm1(-(double)extinction_per_m));
    assert_near(found, opacity, 0.1 * scale);
    sum += (found - opacity) * (found - opacity) / (scale * scale);
    count += opacity == scale;
  }
  assert_true(count > 2000); /* out of 4000 rays: the others leave the volume on one side of the sheet */
  print_message("rms error %.4f of the opacity, %d rays through\n", sqrt(sum / 4000.0), count);
  assert_true(sqrt(sum / 4000.0) < 0.5 * tolerance);
  test_world_destroy(&w);
}

static void no_thin_sheet_is_missed(void **state) {
  (void)state;
  static const float extinctions_per_m[] = {0.02f, 0.5f, 8.0f};
  for (int i = 0; i < 3; i++) {
    check_sheet(sheet_level, extinctions_per_m[i]);
    check_sheet(sheet_tilted, extinctions_per_m[i]);
    check_sheet(sheet_in_haze, extinctions_per_m[i]);
  }
}

/* A lit sheet in haze, at any angle. With the sun along the line of sight the answer is known for any
 * density: light that comes from straight behind is E·p·τ·e^{−τ}, as each of its ways is as deep as the ray; light that
 * goes straight back is E·p·(1 − e^{−2τ})/2. E·p is 1 here. Errors are of the light there would
 * be if nothing were in shadow, 1 − e^{−τ}. */
static void a_lit_sheet_shines_through_haze(void **state) {
  (void)state;
  test_world w;
  start(&w, sheet_in_haze, 1.0f);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  double sum[2] = {0};
  enum { COUNT = 3000 };
  for (int i = 0; i < COUNT; i++) {
    const np_camera_ray ray = draw_ray(&random);
    const double depth = march_compute_depth(&w.placed[0], ray.origin, ray.direction);
    const double expected[2] = {depth * exp(-depth), -0.5 * expm1(-2.0 * depth)};
    for (int is_back = 0; is_back < 2; is_back++) {
      np_integrator_sample sample;
      w.world.to_sun = np_vec3_scale(ray.direction, is_back ? -1.0f : 1.0f);
      test_world_march(&w, &ray, &random, &sample);
      const double error = (double)sample.component[NP_COMPONENT_SUN].band[0] - expected[is_back];
      sum[is_back] += error * error / (expm1(-depth) * expm1(-depth)) / COUNT;
    }
  }
  print_message("rms error %.4f lit from behind, %.4f from the front\n", sqrt(sum[0]), sqrt(sum[1]));
  assert_true(sqrt(sum[0]) < (double)w.settings.tolerance);
  assert_true(sqrt(sum[1]) < (double)w.settings.tolerance);
  test_world_destroy(&w);
}

static float box_far_away(double x, double y, double z) { return x > 24.5 && y > 24.5 && z > 24.5 ? 1.0f : 0.0f; }

/* Empty space costs no look-ups, and an opaque ray ends. */
static void looks_only_where_something_is(void **state) {
  (void)state;
  test_world w;
  start(&w, box_far_away, 1.0f);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  np_integrator_sample sample;
  const np_camera_ray empty = {.origin = {-10.0, 20.3, 30.7}, .direction = {1.0f, 0.0f, 0.0f}, .jitter = 0.5f};
  march_lookups = 0;
  np_march_sample_counted(&w.world, &w.lighting, &w.settings, &empty, &random, &sample);
  assert_int_equal(march_lookups, 0);
  assert_true(sample.transmittance == 1.0f);
  /* 10 m of depth 100 each: dark after a fraction of the first, where the march ends, or one of a thousand goes on. */
  w.placed[0].extinction_per_value = 100.0f;
  const np_camera_ray full = {.origin = {-10.0, 66.3, 66.7}, .direction = {1.0f, 0.0f, 0.0f}, .jitter = 0.5f};
  np_march_sample_counted(&w.world, &w.lighting, &w.settings, &full, &random, &sample);
  assert_true(sample.transmittance == 0.0f);
  test_world_destroy(&w);
}

/* ---- Errors and look-ups ---- */

/* Lumps in a tenth or so of a box, as a field of clouds in its bounds. */
static float lumps(double x, double y, double z) {
  const double u = x + 0.5 * (EDGE - 1), v = y + 0.5 * (EDGE - 1), w = z + 0.5 * (EDGE - 1);
  double density = 0.0;
  for (int n = 0; n < 12; n++) {
    const double cu = 36.0 + 26.0 * sin(2.4 * n), cv = 36.0 + 26.0 * sin(3.7 * n + 1.0),
                 cw = 36.0 + 20.0 * sin(5.1 * n);
    const double r = 5.0 + 4.0 * sin(1.3 * n),
                 d = ((u - cu) * (u - cu) + (v - cv) * (v - cv) + (w - cw) * (w - cw)) / (r * r);
    const double detail = 1.0 + 0.5 * sin(1.1 * u + 0.3 * v) * sin(0.9 * v - 0.4 * w) * sin(1.3 * w + 0.2 * u);
    density += fmax(0.0, detail - 1.3 * d);
  }
  return (float)density;
}

static void start_picture(const test_world *w, march_picture *p) {
  march_picture_init(p, w->placed[0].bricks, w->placed[0].extinction_per_value);
  for (int a = 0; a < 3; a++) p->high[a] = EDGE;
  p->up = 2;
  p->width = p->height = 48;
  march_picture_light(p, 40.0 * NP_DEGREE, 130.0 * NP_DEGREE);
}

/* Two tolerances a factor of eight apart: the error of a pixel is below each, and falls by more than half of that. */
static void errors_follow_the_tolerance(void **state) {
  (void)state;
  static march_picture p;
  test_world w;
  start(&w, lumps, 0.7f);
  start_picture(&w, &p);
  const march_point coarse = march_picture_measure(&p, 0.08f), fine = march_picture_measure(&p, 0.01f);
  print_message("error %.4f for %.1f look-ups, %.4f for %.1f\n", coarse.error, coarse.lookups, fine.error,
                fine.lookups);
  assert_true(coarse.error < 0.08);
  assert_true(fine.error < 0.01);
  assert_true(fine.error < 0.25 * coarse.error);
  test_world_destroy(&w);
}

/* Jittered exponential Euler with a fixed step needs 16 times the look-ups and more for equal error, at the best of
 * three ratios of its two steps. */
static void needs_a_sixteenth_of_fixed_steps(void **state) {
  (void)state;
  static march_picture p;
  march_point baseline[12];
  test_world w;
  start(&w, lumps, 0.7f);
  start_picture(&w, &p);
  int count = 0;
  for (double step = 1.0; step > 0.1; step *= 0.5)
    for (double ratio = 1.0; ratio <= 4.0; ratio *= 2.0)
      baseline[count++] = march_picture_measure_euler(&p, step, step * ratio);
  for (float tolerance = 0.04f; tolerance > 0.015f; tolerance *= 0.5f) {
    const march_point m = march_picture_measure(&p, tolerance);
    const double ratio = march_points_compute_lookups(baseline, count, m.error, false) / m.lookups;
    print_message("error %.4f: fixed steps look %.1f times as often\n", m.error, ratio);
    assert_true(ratio >= 16.0);
  }
  test_world_destroy(&w);
}

/* ---- Transmittance ---- */

/* Ratio tracking (Novák, Selle and Jarosz 2014) against the maximum of each cell. */
static double track_ratio(const np_instance *cloud, np_dvec3 origin, np_vec3 direction, np_random *random) {
  np_brick_walk walk;
  np_brick_span span;
  double weight = 1.0, flight = np_track_flight(random);
  np_track_start(&walk, cloud, origin, direction, 0.0, INFINITY);
  while (np_brick_walk_next(&walk, &span)) {
    const double majorant = (double)(cloud->extinction_per_value * span.range.max);
    double t = span.t_begin;
    for (; flight < majorant * (span.t_end - t); flight = np_track_flight(random)) {
      t += flight / majorant;
      const float value = span.brick == NP_BRICK_NONE
                              ? span.range.min
                              : np_brick_sample(cloud->bricks, span.brick, np_brick_walk_local(&walk, &span, t));
      weight *= 1.0 - (double)(value / span.range.max);
    }
    flight -= majorant * (span.t_end - t);
  }
  return weight;
}

/* Mean square error times look-ups, of the tracer's transmittance and of ratio tracking with the same majorants, from
 * where light scatters. Times say the same on a quiet machine (bench_transmittance), but are no test. */
static void transmittance_beats_ratio_tracking(void **state) {
  (void)state;
  test_world w;
  start(&w, lumps, 0.7f);
  np_random random = np_random_start(4, 0, 0, 0, 0);
  const np_vec3 to_sun = np_vec3_normalize(np_vec3_make(0.3f, 0.4f, 0.9f));
  double squares[2] = {0};
  unsigned long lookups[2] = {0};
  for (int ray = 0; ray < 2000;) {
    double place[3];
    for (int a = 0; a < 3; a++) place[a] = EDGE * np_random_double(&random);
    const np_dvec3 origin = np_dvec3_make(place[0], place[1], place[2]);
    if (np_bricks_sample(w.placed[0].bricks, origin) < 3.0f * np_random_float(&random)) continue;
    const double expected = exp(-march_compute_depth(&w.placed[0], origin, to_sun));
    for (int k = 0; k < 16; k++) {
      march_lookups = 0;
      const float traced =
          np_track_transmittance(&w.world.clouds, origin, to_sun, INFINITY, np_track_faint_depth, &random);
      squares[0] += pow((double)traced - expected, 2.0);
      lookups[0] += march_lookups;
      march_lookups = 0;
      squares[1] += pow(track_ratio(&w.placed[0], origin, to_sun, &random) - expected, 2.0);
      lookups[1] += march_lookups;
    }
    ray++;
  }
  const double gain = squares[1] * (double)lookups[1] / (squares[0] * (double)lookups[0]);
  print_message("%.0f times less error times look-ups than ratio tracking\n", gain);
  assert_true(gain >= 3.0);
  test_world_destroy(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_thin_sheet_is_missed),          cmocka_unit_test(a_lit_sheet_shines_through_haze),
      cmocka_unit_test(looks_only_where_something_is),    cmocka_unit_test(errors_follow_the_tolerance),
      cmocka_unit_test(needs_a_sixteenth_of_fixed_steps), cmocka_unit_test(transmittance_beats_ratio_tracking),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
