/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for paths through clouds, air and to the ground. */
#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/csv.h"
#include "test_skies.h"
#include "test_reference_rows.h"
#include "test_sum.h"
#include "test_world.h"

/* Four standard errors: one value in 16,000 lies beyond by chance; the seeds are fixed, so none does. */
static const double sigmas = 4.0;

typedef struct scene {
  test_world base;
  neph_atmosphere *atmosphere;
} scene;

/* The sun alone over ground, in air or, with NULL, in none. */
static void start(scene *s, const neph_atmosphere_desc *air, double planet_radius_m, np_dvec3 to_sun) {
  test_world_init(&s->base, test_context_create(1, NULL));
  s->atmosphere = air ? test_atmosphere_create(s->base.context, air) : NULL;
  np_world *world = &s->base.world;
  world->to_sun = np_dvec3_to_float(to_sun);
  world->sun_angular_radius_rad = 0.00467396f;
  world->sun_irradiance = np_spectrum_make(1.474f, 1.8504f, 1.91198f);
  world->atmosphere = s->atmosphere;
  world->has_planet = true;
  world->planet_radius_m = planet_radius_m;
  world->ground_albedo = np_spectrum_grey(0.3f);
  s->base.settings = (np_integrator_settings){.scattering_max = UINT32_MAX, .is_air_traced = true};
}

enum { EDGE = 9 };

/* A box of even extinction, its middle `altitude_m` over the origin; the field falls to 0 over one sample more. */
static void add_box(scene *s, double width_m, double height_m, double altitude_m, float depth, np_phase phase) {
  test_cloud box = test_cloud_make(test_full, depth / (float)height_m, phase);
  box.edge = EDGE;
  box.step_m = np_dvec3_make(width_m / EDGE, width_m / EDGE, height_m / EDGE);
  box.middle_m.z = altitude_m;
  assert_int_equal(test_world_add(&s->base, box), NEPH_OK);
}

static void end(scene *s) {
  neph_atmosphere_release(s->atmosphere);
  test_world_destroy(&s->base);
}

/* Means over samples, of each band, and their standard errors. */
typedef struct estimate {
  test_sum sum[3], square[3];
  int count;
  double mean[3], error[3];
} estimate;

static void estimate_add(estimate *e, const double value[3]) {
  for (int b = 0; b < 3; b++) {
    test_sum_add(&e->sum[b], value[b]);
    test_sum_add(&e->square[b], value[b] * value[b]);
  }
  e->count++;
}

static void estimate_finish(estimate *e) {
  for (int b = 0; b < 3; b++) {
    e->mean[b] = test_sum_total(&e->sum[b]) / e->count;
    const double variance = test_sum_total(&e->square[b]) / e->count - e->mean[b] * e->mean[b];
    e->error[b] = sqrt(fmax(variance, 0.0) / (e->count - 1));
  }
}

/* Radiance along one path; returns the radiance that the limit on scatterings took from it. */
static np_spectrum sample(const scene *s, const np_camera_ray *ray, np_random *random, double out_radiance[3]) {
  np_integrator_sample out;
  test_world_path(&s->base, ray, random, &out);
  for (int b = 0; b < 3; b++) out_radiance[b] = test_sum_components(&out, b);
  return out.lost;
}

static estimate trace(const scene *s, np_dvec3 origin, np_dvec3 direction, int count, uint64_t seed) {
  np_camera_ray ray = {.origin = origin, .direction = np_dvec3_to_float(direction)};
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  estimate e = {.count = 0};
  for (int i = 0; i < count; i++) {
    double radiance[3];
    ray.choice = np_random_float(&random);
    (void)sample(s, &ray, &random, radiance);
    estimate_add(&e, radiance);
  }
  estimate_finish(&e);
  return e;
}

static void assert_estimate(const char *what, const estimate *e, const double expected[3], const double error[3]) {
  print_message("%s: %.6g %.6g %.6g +- %.2g %.2g %.2g, expected %.6g %.6g %.6g\n", what, e->mean[0], e->mean[1],
                e->mean[2], e->error[0], e->error[1], e->error[2], expected[0], expected[1], expected[2]);
  for (int b = 0; b < 3; b++) {
    assert_true(isfinite(e->error[b]));
    assert_near(e->mean[b], expected[b], sigmas * hypot(e->error[b], error ? error[b] : 0.0) + 1e-6 * expected[b]);
  }
}

/* ---- Air ---- */

/* Every so many rows of tests/data/sky_traced.csv that look up from the ground: the sky's own reference, which shares
 * the description of the air with the tracer, and neither its flights nor its weights. */
static void compare_sky(double sun_deg, unsigned every, int count) {
  np_csv csv;
  scene s;
  test_air air;
  test_air_start(&air);
  test_air_set_one_lobe(&air);
  start(&s, &air.desc, 6360e3, test_direction(sun_deg, 0.0));
  assert_int_equal(np_csv_load(s.base.context, NEPHOS_TEST_SOURCE_DIR "/data/sky_traced.csv", &csv), NEPH_OK);
  unsigned number = 0;
  for (size_t i = 0; i < csv.row_count; i++) {
    if (strcmp(np_csv_get_field(&csv, i, 0), "sky_radiance") != 0 || test_row_get(&csv, i, 3) != 0.0 ||
        test_row_get(&csv, i, 5) != sun_deg || number++ % every)
      continue;
    double reference[3], error[3];
    for (int b = 0; b < 3; b++) {
      reference[b] = test_row_get(&csv, i, TEST_REFERENCE + b);
      error[b] = test_row_get(&csv, i, TEST_REFERENCE + 3 + b);
    }
    const double zenith = test_row_get(&csv, i, 6), azimuth = test_row_get(&csv, i, 7);
    const estimate e = trace(&s, np_dvec3_make(0, 0, 0), test_direction(zenith, azimuth), count, i);
    char what[64];
    (void)snprintf(what, sizeof what, "sun %g, direction %g, %g", sun_deg, zenith, azimuth);
    assert_estimate(what, &e, reference, error);
  }
  np_csv_clear(&csv);
  end(&s);
}

static void skies_are_the_references(void **state) {
  (void)state;
  compare_sky(45.0, 8, 20000);
  compare_sky(85.0, 8, 20000);
  compare_sky(90.0, 8, 20000);
  compare_sky(96.0, 8, 20000);
}

/* One direction of a planet of this radius against the sky's own reference, ground included. */
static void compare_planet(double radius_m, double sun_deg, np_dvec3 origin, np_dvec3 direction, int count) {
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  desc.planet_radius_m = radius_m;
  scene s;
  start(&s, &desc, radius_m, test_direction(sun_deg, 0.0));
  const np_reference_scene reference = {.medium = &s.atmosphere->medium,
                                        .light = NP_REFERENCE_DISK,
                                        .to_sun = test_direction(sun_deg, 0.0),
                                        .sun_angular_radius_rad = 0.00467396,
                                        .order_min = 1,
                                        .order_max = NP_REFERENCE_ORDERS_ALL,
                                        .guide = &s.atmosphere->depths,
                                        .has_ground = true};
  const np_reference_query query = {origin, direction, INFINITY, false};
  np_reference_value value;
  assert_int_equal(np_reference_radiance(s.base.context, NULL, &reference, &query, (unsigned)count, 7, &value),
                   NEPH_OK);
  for (int b = 0; b < 3; b++) {
    value.mean[b] *= (double)s.base.world.sun_irradiance.band[b];
    value.error[b] *= (double)s.base.world.sun_irradiance.band[b];
  }
  const estimate e = trace(&s, origin, direction, count, 5);
  char what[96];
  (void)snprintf(what, sizeof what, "radius %g, sun %g, height %.0f", radius_m, sun_deg, origin.z);
  assert_estimate(what, &e, value.mean, value.error);
  end(&s);
}

/* Air is as high as a small planet is wide, and flat over a large one; seen from the ground and from space, downwards
 * and past the limb. */
static void planets_of_all_sizes_are_the_references(void **state) {
  (void)state;
  static const double radii[] = {100e3, 100000e3};
  for (int i = 0; i < 2; i++) {
    const double radius = radii[i], space = 400e3;
    const double limb_deg = 180.0 - asin((radius + 20e3) / (radius + space)) / NP_DEGREE;
    for (int low = 0; low < 2; low++) {
      const double sun_deg = low ? 88.0 : 50.0;
      compare_planet(radius, sun_deg, np_dvec3_make(0, 0, 0), test_direction(75.0, 40.0), 4000);
      compare_planet(radius, sun_deg, np_dvec3_make(0, 0, space), test_direction(175.0, 20.0), 4000);
      compare_planet(radius, sun_deg, np_dvec3_make(0, 0, space), test_direction(limb_deg, 30.0), 4000);
    }
  }
}

/* Under the surface there is the ground at once: its light is that of the surface above, times its albedo, and no path
 * climbs for ever, white as the ground may be. */
static void underground_there_is_ground(void **state) {
  (void)state;
  static const double depths_m[] = {1.0, 400.0, 100e3};
  scene s;
  start(&s, NULL, 6360e3, test_direction(40.0, 0.0));
  s.base.world.sun_irradiance = np_spectrum_grey(1.0f);
  s.base.world.ground_albedo = np_spectrum_grey(1.0f);
  const double expected = cos(40.0 * NP_DEGREE) / NP_PI;
  for (int i = 0; i < 3; i++)
    for (int up = 0; up < 2; up++) {
      const np_dvec3 origin = {0, 0, -depths_m[i]}, direction = test_direction(up ? 20.0 : 130.0, 70.0);
      const estimate e = trace(&s, origin, direction, 1000, 3);
      /* Float normals and the disk's width: a convex planet does not light itself, so there is no noise but the disk's.
       */
      assert_estimate("underground", &e, (const double[3]){expected, expected, expected},
                      (const double[3]){1e-5, 1e-5, 1e-5});
    }
  end(&s);
}

/* Air that absorbs nothing, `density` times the Earth's, over white ground under a white sky: whatever is in it cannot
 * be seen. */
static void look_into_furnace(double density, bool has_cloud, int count) {
  test_air air;
  test_air_start(&air);
  test_air_scale(&air, TEST_OZONE, 0.0);
  test_air_scale(&air, TEST_MOLECULES, density);
  test_air_scale(&air, TEST_AEROSOL, density);
  for (int b = 0; b < 3; b++) air.layers[TEST_AEROSOL].absorption_per_m[b] = 0.0;
  scene s;
  start(&s, &air.desc, 6360e3, test_direction(30.0, 0.0));
  s.base.world.sun_irradiance = np_spectrum_grey(0.0f);
  s.base.world.environment_radiance = np_spectrum_grey(1.0f);
  s.base.world.ground_albedo = np_spectrum_grey(1.0f);
  if (has_cloud) add_box(&s, 3e3, 2e3, 2e3, 6.0f, np_phase_henyey_greenstein(0.85f));
  static const double elevations[] = {8.0, 30.0, -5.0, -40.0};
  static const double white[3] = {1.0, 1.0, 1.0};
  for (int i = 0; i < 4; i++) {
    const double height = i == 3 ? 9e3 : 1e3;
    const estimate e = trace(&s, np_dvec3_make(-9e3, 0, height), test_direction(90.0 - elevations[i], 0.0), count, i);
    assert_estimate("furnace", &e, white, NULL);
  }
  end(&s);
}

static void white_furnace_is_invisible(void **state) {
  (void)state;
  look_into_furnace(1.0, true, 20000);
  look_into_furnace(20.0, false, 10000); /* blue is 4 deep where red is 0.8: bands far apart, and many scatterings */
}

/* ---- Ground ---- */

/* A plane, near enough: ground under a layer that absorbs. */
static void absorbing_layer_dims_the_ground(void **state) {
  (void)state;
  const double mu0 = 0.8, mu = 0.6, depth = 0.7;
  scene s;
  start(&s, NULL, 1e12, test_direction(acos(mu0) / NP_DEGREE, 0.0));
  s.base.world.sun_irradiance = np_spectrum_grey(1.0f);
  s.base.world.sun_angular_radius_rad = 0.0f;
  add_box(&s, 2e7, 2e3, 5e3, (float)depth, np_phase_isotropic());
  s.base.placed[0].albedo = np_spectrum_grey(0.0f);
  const np_dvec3 down = test_direction(180.0 - acos(mu) / NP_DEGREE, 70.0);
  const estimate e = trace(&s, np_dvec3_make(0, 0, 10e3), down, 20000, 1);
  const double expected = mu0 * 0.3 / NP_PI * exp(-depth / mu0 - depth / mu);
  assert_estimate("ground under a layer", &e, (const double[3]){expected, expected, expected}, NULL);
  end(&s);
}

/* White ground under a layer that absorbs nothing sends all light back: the mean over directions, by their cosine, of
 * the radiance above is E·μ0/π. Light goes up and down between them some ten times. */
static void light_between_cloud_and_white_ground_is_kept(void **state) {
  (void)state;
  const double mu0 = 0.7;
  scene s;
  start(&s, NULL, 1e12, test_direction(acos(mu0) / NP_DEGREE, 0.0));
  s.base.world.sun_irradiance = np_spectrum_grey(1.0f);
  add_box(&s, 2e7, 2e3, 5e3, 8.0f, np_phase_henyey_greenstein(0.7f));
  s.base.world.ground_albedo = np_spectrum_grey(1.0f);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  estimate e = {.count = 0};
  for (int i = 0; i < 20000; i++) {
    const double zenith = acos(sqrt(1.0 - np_random_double(&random))) / NP_DEGREE;
    const np_dvec3 down = test_direction(180.0 - zenith, 360.0 * np_random_double(&random));
    const np_camera_ray ray = {.origin = {0, 0, 10e3}, .direction = np_dvec3_to_float(down)};
    double radiance[3];
    (void)sample(&s, &ray, &random, radiance);
    estimate_add(&e, radiance);
  }
  estimate_finish(&e);
  const double expected = mu0 / NP_PI;
  assert_estimate("energy", &e, (const double[3]){expected, expected, expected}, NULL);
  end(&s);
}

/* ---- The limit ---- */

/* The light within a limit and the light reported as lost add up to all. */
static void the_light_beyond_a_limit_is_reported(void **state) {
  (void)state;
  scene s;
  start(&s, NULL, 1e12, test_direction(40.0, 0.0));
  add_box(&s, 4e3, 2e3, 3e3, 12.0f, np_phase_henyey_greenstein(0.85f));
  const np_dvec3 origin = {-8e3, 0, 3e3}, direction = {1, 0, 0};
  const estimate whole = trace(&s, origin, direction, 40000, 1);
  s.base.settings.scattering_max = 6;
  s.base.settings.lost_share = 1.0f / 8.0f;
  np_random random = np_random_start(2, 0, 0, 0, 0);
  const np_camera_ray ray = {.origin = origin, .direction = np_dvec3_to_float(direction)};
  estimate both = {.count = 0};
  double lost = 0.0;
  for (int i = 0; i < 40000; i++) {
    double radiance[3];
    const np_spectrum taken = sample(&s, &ray, &random, radiance);
    for (int b = 0; b < 3; b++) radiance[b] += (double)taken.band[b];
    lost += (double)taken.band[0] / 40000.0;
    estimate_add(&both, radiance);
  }
  estimate_finish(&both);
  print_message("six scatterings lose %.1f %%\n", 100.0 * lost / whole.mean[0]);
  assert_true(lost > 0.3 * whole.mean[0] && lost < whole.mean[0]);
  assert_estimate("kept and lost", &both, whole.mean, whole.error);
  end(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(skies_are_the_references),
      cmocka_unit_test(planets_of_all_sizes_are_the_references),
      cmocka_unit_test(underground_there_is_ground),
      cmocka_unit_test(white_furnace_is_invisible),
      cmocka_unit_test(absorbing_layer_dims_the_ground),
      cmocka_unit_test(light_between_cloud_and_white_ground_is_kept),
      cmocka_unit_test(the_light_beyond_a_limit_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
