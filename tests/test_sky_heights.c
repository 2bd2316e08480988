/* SPDX-License-Identifier: Apache-2.0 */
/* The sky's tables against a march over the same sources: through the horizon, from any height, down into the night. */
#include "test_support.h"
#include "test_skies.h"

#include <stdlib.h>

#include "atmosphere/sky_query.h"

static np_sky_subject make_witness(neph_atmosphere *earth) {
  return (np_sky_subject){
      .atmosphere = earth, .sun_angular_radius_rad = 0.00467396, .irradiance_w_m2_nm = {1.0, 1.0, 1.0}};
}

static void ask(np_sky_subject *w, np_sky_method method, const np_sky_query *q, np_reference_value *out) {
  w->method = method;
  assert_int_equal(np_sky_query_eval(w, q, 0, NULL, out), NEPH_OK);
}

static np_sky_query make_query(np_sky_quantity quantity, double altitude_m, double sun_deg, double view_deg,
                               double azimuth_deg) {
  return (np_sky_query){.quantity = quantity,
                        .order_max = NP_ORDERS_ALL,
                        .altitude_m = altitude_m,
                        .sun_zenith_rad = sun_deg * NP_DEGREE,
                        .view_zenith_rad = view_deg * NP_DEGREE,
                        .azimuth_rad = azimuth_deg * NP_DEGREE,
                        .distance_m = 1e7};
}

/* ---- Across the horizon ---- */

/* A thousand directions from two degrees above the true horizon to two below. From one to the next the table may not
 * step otherwise than the march does by more than the tolerance: 0.7 % by day, 2 % at 93 degrees. */
static void scan_horizon(np_sky_subject *w, double altitude_m, double sun_deg, double azimuth_deg, double allowed) {
  const double horizon = np_horizon_angle(&w->atmosphere->medium, altitude_m, 0.0) / NP_DEGREE;
  double before[3] = {0}, worst = 0.0;
  for (int i = 0; i < 1000; i++) {
    const double view = horizon - 2.0 + 4.0 * (i + 0.5) / 1000;
    const np_sky_query q = make_query(NP_SKY_RADIANCE, altitude_m, sun_deg, view, azimuth_deg);
    np_reference_value table, marched;
    ask(w, NP_SKY_LUT, &q, &table);
    ask(w, NP_SKY_MARCH, &q, &marched);
    for (int b = 0; b < 3; b++) {
      const double off = log(table.mean[b] / marched.mean[b]);
      if (i > 0) worst = fmax(worst, fabs(off - before[b]));
      before[b] = off;
    }
  }
  print_message("horizon from %g m, sun %g, azimuth %g: steps of %.2f %%\n", altitude_m, sun_deg, azimuth_deg,
                100.0 * worst);
  assert_true(worst <= allowed);
}

static void the_horizon_has_no_step_of_its_own(void **state) {
  np_sky_subject w = make_witness(*state);
  scan_horizon(&w, 1.7, 40.0, 20.0, 0.007);
  scan_horizon(&w, 500.0, 85.0, 10.0, 0.007);
  scan_horizon(&w, 11e3, 60.0, 170.0, 0.007);
  scan_horizon(&w, 2e3, 93.0, 30.0, 0.02);
  scan_horizon(&w, 400e3, 60.0, 60.0, 0.02);
  np_sky_subject_clear(&w);
}

/* ---- Aerial perspective from any height ---- */

typedef struct look {
  double view_deg, azimuth_deg, part; /* share of the ray's way through the air */
} look;

enum { LOOKS = 12 * 3 * 4 };

/* Directions from 30 degrees below the horizon to 20 above, towards the sun, across and away, to four parts of the way.
 */
static look choose_look(double horizon_deg, int i) {
  static const double above[12] = {-30, -8, -2, -0.5, 0.05, 0.3, 1, 2, 4, 6, 10, 20};
  static const double parts[4] = {0.1, 0.4, 0.8, 0.99};
  return (look){horizon_deg - above[i / 12], 5.0 + 85.0 * (i / 4 % 3), parts[i % 4]};
}

/* Errors are over the in-scatter, and 2 % of the brightest one of the sky on top: in the planet's shadow a part of
 * nothing is nothing. Worst 15 % of one look, at the shadow's edge in twilight from 35 km; by day 5 %. */
static void compare_height(np_sky_subject *w, double altitude_m, double sun_deg, double rms_max) {
  const double horizon = np_horizon_angle(&w->atmosphere->medium, altitude_m, 0.0) / NP_DEGREE;
  np_reference_value table[LOOKS], marched[LOOKS];
  double bright[3] = {0}, square = 0.0, worst = 0.0;
  unsigned count = 0;
  for (int i = 0; i < LOOKS; i++) {
    const look l = choose_look(horizon, i);
    np_sky_query q = make_query(NP_SKY_AP_INSCATTER, altitude_m, sun_deg, l.view_deg, l.azimuth_deg);
    const np_ray ray = np_ray_make(&w->atmosphere->medium, altitude_m, cos(q.view_zenith_rad));
    q.distance_m = ray.offset_m + l.part * ray.length_m;
    ask(w, NP_SKY_LUT, &q, &table[i]);
    ask(w, NP_SKY_MARCH, &q, &marched[i]);
    for (int b = 0; b < 3; b++) bright[b] = fmax(bright[b], marched[i].mean[b]);
  }
  for (int i = 0; i < LOOKS; i++)
    for (int b = 0; b < 3; b++) {
      const double off = fabs(table[i].mean[b] - marched[i].mean[b]) / (marched[i].mean[b] + 0.02 * bright[b]);
      worst = fmax(worst, off);
      square += off * off;
      count++;
    }
  print_message("aerial perspective from %g km, sun %g: %.2f %% rms, worst %.1f %%\n", altitude_m / 1000.0, sun_deg,
                100.0 * sqrt(square / count), 100.0 * worst);
  assert_true(sqrt(square / count) <= rms_max && worst <= 0.2);
}

/* 1.2 % where the gate is, near the ground, and where aeroplanes and balloons are; 2 % from higher up, as the
 * sky's own gate; 2.5 % and 4 % with the sun 3 degrees down. */
static void aerial_perspective_holds_from_any_height(void **state) {
  static const double heights_km[] = {0.5, 10, 35, 50, 70, 90, 120, 400};
  np_sky_subject w = make_witness(*state);
  for (size_t i = 0; i < sizeof heights_km / sizeof *heights_km; i++) {
    const double h = heights_km[i] * 1000.0, by_day = h < 40e3 ? 0.012 : 0.02;
    compare_height(&w, h, 30.0, by_day);
    compare_height(&w, h, 80.0, by_day);
    compare_height(&w, h, 93.0, h < 1e3 ? 0.025 : 0.04);
  }
  np_sky_subject_clear(&w);
}

/* ---- Into the night ---- */

static double look_west(const neph_sky *sky, double zenith_deg) {
  const np_spectrum light = np_sky_radiance(sky, np_dvec3_to_float(test_direction(zenith_deg, 0.0)));
  for (int b = 0; b < 3; b++) assert_true(isfinite(light.band[b]) && light.band[b] >= 0.0f);
  return (double)light.band[1];
}

/* Sunlight falls all the way from level to nadir; it is gone at 19 degrees, and with it the tables, except for the
 * air's optical depths, through which the stars are visible. */
static void the_suns_sky_ends_at_nineteen_degrees(void **state) {
  double before = INFINITY;
  for (int i = 0; i <= 90; i++) {
    const double sun = 90.0 + i;
    neph_sky *sky = test_sky_create(*state, 0.0, sun);
    const double light = look_west(sky, 80.0);
    assert_true(light <= before);
    assert_int_equal(light > 0.0, sun < 109.0);
    assert_int_equal(sky->view != NULL && sky->aerial != NULL, sun < 109.0);
    const np_aerial_perspective air = np_sky_aerial_perspective(sky, np_dvec3_to_float(test_direction(80.0, 0.0)), 1e6);
    assert_true(air.transmittance.band[1] > 0.3f && air.transmittance.band[1] < 0.8f);
    assert_true(air.inscatter.band[1] >= 0.0f && (sun < 109.0 || air.inscatter.band[1] == 0.0f));
    before = light;
    neph_sky_destroy(sky);
  }
}

static void night_is_where_the_planet_hides_the_sun(void **state) {
  neph_sky *below = test_sky_create(*state, 400e3, 120.0), *far = test_sky_create(*state, 400e3, 140.0);
  assert_non_null(below->view); /* 30 degrees under the level, 10 under the horizon from there */
  assert_null(far->view);
  neph_sky_destroy(below);
  neph_sky_destroy(far);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_horizon_has_no_step_of_its_own),
      cmocka_unit_test(aerial_perspective_holds_from_any_height),
      cmocka_unit_test(the_suns_sky_ends_at_nineteen_degrees),
      cmocka_unit_test(night_is_where_the_planet_hides_the_sun),
  };
  return cmocka_run_group_tests(tests, test_earth_start, test_earth_end);
}
