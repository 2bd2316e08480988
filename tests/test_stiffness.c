/* SPDX-License-Identifier: Apache-2.0 */
/* The march and the sweep as equations that are stiff where extinction times step is far above 1: errors stay bounded
 * as the depth of a voxel grows without bound, the order is that of the method where they are not stiff, and the
 * work is bounded. */
#include "march_count.h"

#include "march_picture.h"
#include "test_stability_page.h"
#include "test_stress_world.h"

#include "transport/scattering_field_private.h"

static test_page page;

static void start(test_world *w, stress_field field, double depth, double albedo, float g) {
  *w = (test_world){0};
  test_world_init(w, test_context_create(2, NULL));
  w->volumes[0] = stress_create_volume(w->context, field);
  w->placed[0] = (np_instance){.bricks = &w->volumes[0]->bricks,
                               .world_to_index = w->volumes[0]->world_to_index,
                               .extinction_per_value = (float)depth,
                               .albedo = np_spectrum_grey((float)albedo),
                               .phase = np_phase_henyey_greenstein(g)};
  w->world.clouds.count = 1;
  w->desc.cells.bounds_min = np_dvec3_make(stress_low_m - 1.0, stress_low_m - 1.0, stress_low_m - 1.0);
  w->desc.cells.bounds_max = np_dvec3_scale(w->desc.cells.bounds_min, -1.0);
  w->desc.cells.cell_count_cheap = 4000;
  w->desc.cells.cell_count_max = 4000;
  w->desc.work_max = 0.0;
}

/* ---- The march ---- */

/* Rms over rays of the error of sunlight scattered back, E·p being 1, whose closed form is (1 − e^−2τ)/2: the source
 * falls as e^−τ along the ray, and is as stiff as the ray. `out_lookups`: a ray. */
static double measure_march(double depth, float tolerance, double *out_lookups) {
  enum { RAYS = 64 };
  test_world w;
  start(&w, STRESS_CONSTANT, depth, 1.0, 0.0f);
  w.settings.scattering_max = 1;
  w.settings.tolerance = tolerance;
  w.settings.transmittance_end = 1e-6f;
  w.world.sun_irradiance = np_spectrum_grey(4.0f * NP_PI_F);
  np_camera_ray ray = stress_make_ray(STRESS_OUTSIDE);
  w.world.to_sun = np_vec3_scale(ray.direction, -1.0f);
  const double tau = (double)(float)depth * stress_compute_depth(STRESS_CONSTANT, ray.origin, ray.direction);
  const double expected = -0.5 * expm1(-2.0 * tau);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double squares = 0.0;
  march_lookups = 0;
  for (int n = 0; n < RAYS; n++) {
    np_integrator_sample sample;
    ray.jitter = ((float)n + 0.5f) / RAYS;
    np_march_sample_counted(&w.world, &w.lighting, &w.settings, &ray, &random, &sample);
    squares += pow((double)sample.component[NP_COMPONENT_SUN].band[0] - expected, 2.0) / RAYS;
  }
  *out_lookups = (double)march_lookups / RAYS;
  test_world_destroy(&w);
  return sqrt(squares) / -expm1(-tau);
}

/* Steps are cut by their own depth, so that a deep voxel is as well resolved as any: at any depth the error is that of
 * the tolerance, of what light there would be without shadow: of single rays six times its half, as in
 * test_march_steps. It is no larger at the greatest depths than before. */
static void the_march_is_stable_at_any_depth(void **state) {
  (void)state;
  static const double depths[] = {1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3, 1e4, 1e6, 1e8};
  double before = 0.0, last = 0.0;
  test_page_add_figure(&page, "\n## Stiffness\n");
  test_page_add_figure(&page, "| depth of a voxel | error of the march | look-ups a ray |\n| --- | --- | --- |");
  for (size_t n = 0; n < sizeof depths / sizeof *depths; n++) {
    double lookups;
    last = measure_march(depths[n], 0.01f, &lookups);
    test_page_add_figure(&page, "| %g | %.2g | %.0f |", depths[n], last, lookups);
    assert_true(last < 0.03);
    assert_true(lookups < 2000.0);
    if (n + 3 < sizeof depths / sizeof *depths) before = fmax(before, last);
  }
  assert_true(last <= before);
}

/* Steps grow as tolerance^⅓, and their error as their square, or faster. In deep voxels the order is lost to pieces of
 * one depth, which make an error of some thousandths at any tolerance. */
static void the_march_is_of_second_order(void **state) {
  (void)state;
  static const double depths[] = {0.3, 3.0, 1e3, 1e6};
  test_page_add_figure(&page, "\n| depth of a voxel | observed order of a step | error at the least tolerance |");
  test_page_add_figure(&page, "| --- | --- | --- |");
  for (size_t n = 0; n < sizeof depths / sizeof *depths; n++) {
    double lookups;
    const double coarse = measure_march(depths[n], 0.08f, &lookups),
                 fine = measure_march(depths[n], 0.00125f, &lookups);
    const double order = 3.0 * log(coarse / fine) / log(64.0);
    test_page_add_figure(&page, "| %g | %.2f | %.2g |", depths[n], order, fine);
    assert_true(order > 1.5 || (depths[n] > 100.0 && fine < 5e-3));
  }
}

/* ---- Free flights ---- */

/* Collisions in a deep field of 0 and 1e6 lie where half of the light is gone, in the mean of what is left of it, and
 * take few look-ups: null collisions were as many as the bricks are deep. */
static void flights_invert_the_depth_of_deep_bricks(void **state) {
  (void)state;
  enum { FLIGHTS = 2000 };
  static const double depths[] = {1e-4, 1.0, 1e4};
  test_page_add_figure(&page, "\n| depth of a voxel | look-ups a flight |\n| --- | --- |");
  for (size_t n = 0; n < sizeof depths / sizeof *depths; n++) {
    test_world w;
    start(&w, STRESS_CHECKERBOARD, depths[n], 1.0, 0.0f);
    const np_camera_ray ray = stress_make_ray(STRESS_OUTSIDE);
    np_random random = np_random_start(7, 0, 0, 0, 0);
    test_tally left = {0};
    march_lookups = 0;
    unsigned long lookups = 0;
    for (int i = 0; i < FLIGHTS; i++) {
      const np_instance *volume;
      np_flight flight = np_flight_start(np_track_flight(&random), 0.0);
      march_lookups = 0;
      const double t =
          np_track_collision(&w.world.clouds, ray.origin, ray.direction, INFINITY, &flight, &random, &volume);
      lookups += march_lookups;
      const np_vec3 back = np_vec3_scale(ray.direction, -1.0f);
      const np_dvec3 at = np_dvec3_along(ray.origin, ray.direction, fmin(t, 100.0));
      test_tally_add(&left, exp(-(double)(float)depths[n] * stress_compute_depth(STRESS_CHECKERBOARD, at, back)));
    }
    test_page_add_figure(&page, "| checkerboard of 0 and %g | %.0f |", 1e6 * depths[n], (double)lookups / FLIGHTS);
    assert_near(test_tally_mean(&left), 0.5, 4.0 * test_tally_error(&left));
    assert_true(lookups < 1000ul * FLIGHTS);
    test_world_destroy(&w);
  }
}

/* ---- The sweep ---- */

/* In a furnace, from the residual and the number of sweeps that it took. */
static double measure_contraction(double depth, double albedo, unsigned *out_sweeps) {
  test_world w;
  start(&w, STRESS_CONSTANT, depth, albedo, 0.0f);
  w.world.environment_radiance = np_spectrum_grey(1.0f);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  const double residual = w.scattering->quality.residual;
  *out_sweeps = w.scattering->sweeps;
  np_random random = np_random_start(1, 0, 0, 0, 0);
  np_integrator_sample sample;
  const np_camera_ray ray = stress_make_ray(STRESS_OUTSIDE);
  test_world_march(&w, &ray, &random, &sample);
  const double light = test_sum_components(&sample, 0);
  assert_true(light >= 0.0 && light <= 1.003);
  if (albedo == 1.0) assert_near(light, 1.0, 0.003); /* the march's tolerance of 1 % leaves less in a furnace */
  assert_true(residual <= 3e-4);
  test_world_destroy(&w);
  return residual > 0.0 ? pow(residual, 1.0 / *out_sweeps) : 0.0;
}

/* Contraction is slowest where cells are deep and white; there it is bounded too. */
static void sweeps_contract_at_any_albedo_and_depth(void **state) {
  (void)state;
  static const double albedos[] = {0.5, 0.9, 0.999995, 1.0};
  static const double depths[] = {0.01, 0.1, 1.0, 10.0, 100.0, 1e4, 1e6};
  double slowest = 0.0;
  unsigned most = 0;
  test_page_add_figure(&page, "\n| depth of a cell | ϖ 0.5 | 0.9 | 0.999995 | 1 |\n| --- | --- | --- | --- | --- |");
  for (size_t d = 0; d < sizeof depths / sizeof *depths; d++) {
    double rates[4];
    for (size_t a = 0; a < 4; a++) {
      unsigned sweeps;
      rates[a] = measure_contraction(depths[d], albedos[a], &sweeps);
      slowest = fmax(slowest, rates[a]);
      most = sweeps > most ? sweeps : most;
    }
    test_page_add_figure(&page, "| %g | %.3f | %.3f | %.3f | %.3f |", depths[d], rates[0], rates[1], rates[2],
                         rates[3]);
  }
  test_page_add_figure(&page, "\nThe slowest contraction is %.3f a sweep, the most sweeps %u.", slowest, most);
  assert_true(slowest < 0.9);
  assert_true(most <= 60);
}

/* A white wall, lit and seen from straight before it: μ₀/(4·(μ + μ₀))·H(1)²/π with H(1) = 2.9078 (Chandrasekhar 1960,
 * "Radiative Transfer", section 33 and table 11). It is the same for any depth of its voxels. The layer that reflects
 * is thinner than a cell, by whose mean it comes out too dark, within a factor of two. */
static void a_deep_wall_is_as_white_as_a_wall(void **state) {
  (void)state;
  const double expected = 0.125 * 2.9078 * 2.9078 / NP_PI;
  double first = 0.0;
  test_page_add_figure(&page, "\n| depth of a voxel | white wall, over the exact one | sweeps |\n| --- | --- | --- |");
  for (double depth = 1e2; depth < 1e9; depth *= 1e2) {
    test_world w;
    start(&w, STRESS_CONSTANT, depth, 1.0, 0.0f);
    np_camera_ray ray = stress_make_ray(STRESS_AXIS);
    ray.origin = np_dvec3_make(0.3, 0.4, -30.0);
    w.world.sun_irradiance = np_spectrum_grey(1.0f);
    w.world.to_sun = np_vec3_scale(ray.direction, -1.0f);
    assert_int_equal(test_world_solve(&w), NEPH_OK);
    np_random random = np_random_start(1, 0, 0, 0, 0);
    np_integrator_sample sample;
    test_world_march(&w, &ray, &random, &sample);
    const double ratio = test_sum_components(&sample, 0) / expected;
    test_page_add_figure(&page, "| %g | %.2f | %u |", depth, ratio, w.scattering->sweeps);
    assert_true(ratio > 0.5 && ratio < 1.2);
    if (first > 0.0) assert_near_relative(ratio, first, 0.15);
    first = first > 0.0 ? first : ratio;
    test_world_destroy(&w);
  }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_march_is_stable_at_any_depth),
      cmocka_unit_test(the_march_is_of_second_order),
      cmocka_unit_test(flights_invert_the_depth_of_deep_bricks),
      cmocka_unit_test(sweeps_contract_at_any_albedo_and_depth),
      cmocka_unit_test(a_deep_wall_is_as_white_as_a_wall),
  };
  page = test_page_open(argc, argv);
  const int result = cmocka_run_group_tests(tests, NULL, NULL);
  test_page_close(&page);
  return result;
}
