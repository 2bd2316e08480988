/* SPDX-License-Identifier: Apache-2.0 */
/* A thousand skies in a row, along the observer's altitude and along the sun's setting: nothing may step.
 *
 * test_sky_scans        sixty skies about the places where tables change their rules
 * test_sky_scans long   a thousand from 1.7 m to 1000 km up, and from 88 to 108 degrees: a minute or two
 *
 * A step J between two skies shows as J in the second difference of the logarithm, in which whatever changes steadily
 * vanishes. What is allowed is twice the tables' own error, 0.7 % by day, 2 % and 10 % in twilight, and above the air,
 * where it is 2 % too.
 */
#include "test_support.h"
#include "test_skies.h"

#include <stdlib.h>

#include "core/math.h"

enum { VIEWS = 4 };

/* Logarithms of the radiance of one sky in a few directions: up, aside, and down. */
static void look(const neph_sky *sky, bool is_up, double out[VIEWS][3]) {
  static const double up[VIEWS][2] = {{10, 90}, {60, 20}, {80, 100}, {85, 170}};
  static const double down[VIEWS][2] = {{180, 0}, {165, 30}, {150, 100}, {140, 160}};
  for (int v = 0; v < VIEWS; v++) {
    const np_dvec3 d = is_up ? test_direction(up[v][0], up[v][1]) : test_direction(down[v][0], down[v][1]);
    const np_spectrum light = np_sky_radiance(sky, np_dvec3_to_float(d));
    for (int b = 0; b < 3; b++) {
      assert_true(isfinite(light.band[b]) && light.band[b] >= 0.0f);
      out[v][b] = log((double)light.band[b] + 1e-12);
    }
  }
}

/* Direction of the sun and altitude of the observer at a part of the way. */
typedef struct stop {
  double altitude_m, sun_deg, allowed;
} stop;

static double second_difference(double a, double b, double c) { return fabs(a - 2.0 * b + c); }

static void run_scan(neph_atmosphere *earth, stop (*at)(double), int count, double from, double to, bool is_up,
                     const char *name) {
  double last[3][VIEWS][3], worst = 0.0, worst_at = 0.0;
  for (int i = 0; i < count; i++) {
    const double part = from + (to - from) * i / (count - 1);
    const stop s = at(part);
    neph_sky *sky = test_sky_create(earth, s.altitude_m, s.sun_deg);
    look(sky, is_up, last[i % 3]);
    neph_sky_destroy(sky);
    for (int v = 0; v < VIEWS && i >= 2; v++)
      for (int b = 0; b < 3; b++) {
        const double step =
            second_difference(last[(i - 2) % 3][v][b], last[(i - 1) % 3][v][b], last[i % 3][v][b]) / s.allowed;
        if (step > worst) worst_at = part;
        worst = fmax(worst, step);
      }
  }
  const stop s = at(worst_at);
  print_message("%s, %d skies: worst step %.2f of what is allowed, at %g m, sun %g deg\n", name, count, worst,
                s.altitude_m, s.sun_deg);
  assert_true(worst <= 1.0);
}

static stop climb(double part) { return (stop){1.7 * pow(1e6 / 1.7, part), 70.0, 0.014}; }
static stop climb_in_space(double part) { return (stop){20e3 * pow(50.0, part), 50.0, 0.04}; }
static stop set_sun(double part) {
  const double sun = 88.0 + 20.0 * part;
  return (stop){500.0, sun, sun < 90.0 ? 0.014 : sun < 97.0 ? 0.04 : 0.2};
}

static void thousand_altitudes(void **state) {
  run_scan(*state, climb, 1000, 0.0, 0.78, true, "looking up");
  run_scan(*state, climb_in_space, 1000, 0.0, 1.0, false, "looking down");
}

static void thousand_suns(void **state) { run_scan(*state, set_sun, 1000, 0.0, 1.0, true, "sunset"); }

static void a_few_altitudes(void **state) {
  run_scan(*state, climb_in_space, 20, 0.40, 0.42, false, "entering space");
  run_scan(*state, climb, 20, 0.55, 0.57, true, "out of the haze");
}

static void a_few_suns(void **state) { run_scan(*state, set_sun, 20, 0.09, 0.11, true, "sunset"); }

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_few_altitudes), cmocka_unit_test(a_few_suns)};
  const struct CMUnitTest long_tests[] = {cmocka_unit_test(thousand_altitudes), cmocka_unit_test(thousand_suns)};
  if (argc > 1 && strcmp(argv[1], "long") == 0)
    return cmocka_run_group_tests(long_tests, test_earth_start, test_earth_end);
  return cmocka_run_group_tests(tests, test_earth_start, test_earth_end);
}
