/* SPDX-License-Identifier: Apache-2.0 */
/* Paths that are guided, split and ended by the march's solution: their mean is that of paths which are not, whatever
 * the cloud, the light and the solution. What it gains in slabs is tested by test_probe. */
#include "test_world.h"

static void start(test_world *w) {
  test_world_create(w, 2, test_cloud_make_on_axes(test_lumpy_ball, 0.0));
  w->desc.has_importance = true;
}

/* Light of all orders, and, apart, of those beyond the first, along rays through the cloud. */
static void trace(test_world *w, bool is_split, test_tally out[2]) {
  w->settings.is_split = is_split;
  np_random random = np_random_start(7, is_split, 0, 0, 0);
  for (int i = 0; i < 20000; i++) {
    const np_camera_ray ray = {.origin = {24.0 * np_random_double(&random), -20.0, 24.0 * np_random_double(&random)},
                               .direction = {0, 1, 0}};
    np_integrator_sample sample;
    test_world_path(w, &ray, &random, &sample);
    test_tally_add(&out[0], test_sum_components(&sample, 1));
    test_tally_add(&out[1], (double)sample.component[NP_COMPONENT_MULTIPLE].band[1]);
  }
}

/* Four standard errors of the difference, of which one in 16,000 is by chance. */
static void assert_no_bias(test_world *w) {
  test_tally plain[2] = {0}, split[2] = {0};
  trace(w, false, plain);
  trace(w, true, split);
  for (int i = 0; i < 2; i++) {
    const double error = hypot(test_tally_error(&plain[i]), test_tally_error(&split[i]));
    print_message("%.5g and %.5g +- %.2g\n", test_tally_mean(&plain[i]), test_tally_mean(&split[i]), error);
    assert_true(test_tally_mean(&plain[i]) > 20.0 * error);
    assert_near(test_tally_mean(&split[i]), test_tally_mean(&plain[i]), 4.0 * error);
  }
}

static void light_like_day(test_world *w) {
  w->world.to_sun = np_vec3_make(0.0f, 0.6f, 0.8f);
  w->world.sun_irradiance = np_spectrum_make(1.0f, 2.0f, 0.5f);
  w->world.sun_angular_radius_rad = 0.005f;
  w->world.environment_radiance = np_spectrum_grey(0.1f);
  w->world.is_environment_upper_only = true;
}

static void a_lumpy_cloud_stays_as_bright(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  assert_no_bias(&w);
  test_world_destroy(&w);
}

/* Nothing but the sun shines from outside: guided paths stay within, but for its disk. */
static void a_cloud_in_space_stays_as_bright(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  w.world.environment_radiance = np_spectrum_grey(0.0f);
  w.world.sun_angular_radius_rad = 0.3f;
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  assert_no_bias(&w);
  test_world_destroy(&w);
}

/* Bands part, and so do the paths' weights. */
static void a_cloud_that_absorbs_stays_as_bright(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  w.placed[0].albedo = np_spectrum_make(0.99f, 0.9f, 0.7f);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  assert_no_bias(&w);
  test_world_destroy(&w);
}

/* The cloud given twice, each time with a share of its extinction. */
static void give_twice(test_world *w, float share) {
  w->placed[0].extinction_per_value *= share;
  w->placed[1] = w->placed[0];
  w->world.clouds.count = 2;
}

static void clouds_that_overlap_stay_as_bright(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  give_twice(&w, 0.5f);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  assert_no_bias(&w);
  test_world_destroy(&w);
}

/* Transmittance through half of two clouds of depth 2.5, and all of them, by flights that leave out a share of the
 * extinction or add to it. */
static void stretched_flights_weigh_what_they_ought(void **state) {
  (void)state;
  test_world w;
  start(&w);
  give_twice(&w, 0.15f);
  const np_dvec3 origin = {12.0, -20.0, 9.0};
  const np_vec3 direction = {0.0f, 1.0f, 0.0f};
  np_random random = np_random_start(9, 0, 0, 0, 0);
  static const double stretch_fraction[] = {0.0, 0.6, -1.5}, end_m[] = {28.0, INFINITY};
  for (int e = 0; e < 2; e++) {
    const double passing = (double)np_track_transmittance(&w.world.clouds, origin, direction, end_m[e], 1e9, &random);
    for (int k = 0; k < 3; k++) {
      test_tally passed = {0}, collided = {0};
      for (int i = 0; i < 100000; i++) {
        np_flight flight = np_flight_start(np_track_flight(&random), stretch_fraction[k]);
        const np_instance *volume;
        const double t = np_track_collision(&w.world.clouds, origin, direction, end_m[e], &flight, &random, &volume);
        const double weight = (double)np_flight_weight(&flight);
        test_tally_add(&passed, isinf(t) ? weight : 0.0);
        test_tally_add(&collided, isinf(t) ? 0.0 : weight);
      }
      assert_near(test_tally_mean(&passed), passing, 4.0 * test_tally_error(&passed));
      assert_near(test_tally_mean(&collided), 1.0 - passing, 4.0 * test_tally_error(&collided));
    }
  }
  test_world_destroy(&w);
}

/* Solved for a sun on the other side, and so wrong by what decades there are in the cloud: it costs time alone. */
static void a_wrong_solution_changes_no_mean(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  w.world.to_sun = np_vec3_make(0.0f, -0.6f, -0.8f);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  light_like_day(&w);
  assert_no_bias(&w);
  test_world_destroy(&w);
}

/* A white cloud amid even light cannot be seen. The solution there is the same everywhere, but for what
 * its iteration left over: most paths are never split, and those that are lose what the sums of floats round off. */
static void a_white_furnace_stays_invisible(void **state) {
  (void)state;
  test_world w;
  start(&w);
  w.world.environment_radiance = np_spectrum_make(1.0f, 2.0f, 3.0f);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  test_tally tally[2] = {0};
  trace(&w, true, tally);
  assert_near(test_tally_mean(&tally[0]), 2.0, fmax(4.0 * test_tally_error(&tally[0]), 1e-5));
  assert_true(test_tally_error(&tally[0]) < 1e-3);
  test_world_destroy(&w);
}

/* The light beyond a limit is estimated from a few paths, which are followed beyond it as the others would be. */
static void the_light_beyond_a_limit_is_reported(void **state) {
  (void)state;
  test_world w;
  start(&w);
  light_like_day(&w);
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  w.settings.is_split = true;
  test_tally all = {0}, kept_and_lost = {0};
  np_random random = np_random_start(8, 0, 0, 0, 0);
  for (int i = 0; i < 30000; i++) {
    const np_camera_ray ray = {.origin = {24.0 * np_random_double(&random), -20.0, 24.0 * np_random_double(&random)},
                               .direction = {0, 1, 0}};
    np_integrator_sample sample;
    w.settings.scattering_max = UINT32_MAX;
    w.settings.lost_share = 0.0f;
    test_world_path(&w, &ray, &random, &sample);
    test_tally_add(&all, test_sum_components(&sample, 1));
    w.settings.scattering_max = 4;
    w.settings.lost_share = 0.25f;
    test_world_path(&w, &ray, &random, &sample);
    test_tally_add(&kept_and_lost, test_sum_components(&sample, 1) + (double)sample.lost.band[1]);
  }
  const double error = hypot(test_tally_error(&all), test_tally_error(&kept_and_lost));
  assert_near(test_tally_mean(&kept_and_lost), test_tally_mean(&all), 4.0 * error);
  test_world_destroy(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_lumpy_cloud_stays_as_bright),        cmocka_unit_test(a_cloud_in_space_stays_as_bright),
      cmocka_unit_test(a_cloud_that_absorbs_stays_as_bright), cmocka_unit_test(a_wrong_solution_changes_no_mean),
      cmocka_unit_test(a_white_furnace_stays_invisible),      cmocka_unit_test(the_light_beyond_a_limit_is_reported),
      cmocka_unit_test(clouds_that_overlap_stay_as_bright),   cmocka_unit_test(stretched_flights_weigh_what_they_ought),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
