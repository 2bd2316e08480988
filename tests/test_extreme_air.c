/* SPDX-License-Identifier: Apache-2.0 */
/* Air at its ends: sun and view through the horizon in millionths of a radian, observers on the ground, at the top and
 * far from the planet, scale heights of a metre and of a thousand kilometres, coefficients a million times as large and
 * as small. Everything is finite, not negative, and changes no faster than the air along the ray does. */
#include "test_skies.h"
#include "test_stability_page.h"

static test_page page;

static const double step_rad = 1e-6;
static const double radius_m = 6360e3, top_m = 100e3, tolerance = 0.1;

/* ---- Airs ---- */

typedef struct extreme_air {
  const char *name;
  double factor;   /* factor on all coefficients */
  double height_m; /* scale height of molecules and aerosol; 0: the Earth's */
} extreme_air;

static const extreme_air airs[] = {
    {"Earth", 1.0, 0.0},
    {"coefficients × 1e-6", 1e-6, 0.0},
    {"coefficients × 1e-3", 1e-3, 0.0},
    {"coefficients × 1e3", 1e3, 0.0},
    {"coefficients × 1e6", 1e6, 0.0},
    {"scale height 1 m", 1.0, 1.0},
    {"scale height 1e6 m", 1.0, 1e6},
};

enum { AIRS = sizeof airs / sizeof *airs };

/* Without ozone the air is the thinner the higher up. */
static neph_atmosphere *create_air(neph_context *context, const extreme_air *extreme, bool has_ozone) {
  test_air air;
  test_air_start(&air);
  for (int layer = 0; layer < NEPH_EARTH_LAYER_COUNT; layer++) {
    test_air_scale(&air, layer, extreme->factor);
    if (extreme->height_m > 0.0 && air.layers[layer].profile == NEPH_LAYER_EXPONENTIAL)
      air.layers[layer].height_m = extreme->height_m;
  }
  if (!has_ozone) air.desc.layer_count = TEST_OZONE;
  air.desc.tolerance = tolerance; /* tables as small as they get: what is held here are bounds */
  return test_atmosphere_create(context, &air.desc);
}

static double get_scale_height(const extreme_air *air) { return air->height_m > 0.0 ? air->height_m : 1.2e3; }

/* Altitudes of observers: the top and its neighbours among doubles are three. */
enum { ALTITUDES = 7 };
static void fill_altitudes(double out[ALTITUDES]) {
  const double all[ALTITUDES] = {0.0, 1e-3, 1.7e3, nextafter(top_m, 0.0), top_m, nextafter(top_m, 1e9), 1e9};
  memcpy(out, all, sizeof all);
}

/* ---- Checks ---- */

typedef struct counts {
  unsigned long skies, rays, transmittances;
  double worst_jump; /* over what is allowed */
  char worst_name[120];
} counts;

static void assert_light(const double v[3], const char *air, double altitude_m) {
  for (int b = 0; b < 3; b++)
    if (!(isfinite(v[b]) && v[b] >= 0.0)) fail_msg("%s, %g m up: light is %g", air, altitude_m, v[b]);
}

static void assert_share(const double v[3], const char *air, double altitude_m) {
  for (int b = 0; b < 3; b++)
    if (!(v[b] >= 0.0 && v[b] <= 1.0)) fail_msg("%s, %g m up: a transmittance is %.17g", air, altitude_m, v[b]);
}

/* Zenith angle of the geometric horizon. */
static double get_horizon(double altitude_m) {
  return NP_PI - asin(fmin(radius_m / (radius_m + fmax(altitude_m, 0.0)), 1.0));
}

static np_dvec3 get_direction(double zenith_rad) { return np_dvec3_make(sin(zenith_rad), 0.0, cos(zenith_rad)); }

/* A step of the view moves the ray's lowest point by its distance times the step, and the light by no more than the
 * density there, e^{Δ/H}, and than the way through the air, over √(2H/R), each twice for light that comes and goes; the
 * interpolation of tables is a hundredth of their tolerance, and a tenth in airs of no real planet. Below the horizon a
 * ray ends √(2RΔ) before it, which is as much of its way as that is of the air's there; above it, tables are
 * interpolated in the same root. At the horizon itself the ground blocks the light behind. */
static double get_allowed(const extreme_air *air, double altitude_m, int step) {
  const double distance = sqrt(fmax(altitude_m, 0.0) * (2.0 * radius_m + fmax(altitude_m, 0.0)));
  const double shift = distance * step_rad, height = get_scale_height(air);
  const double way = fmin(distance, sqrt(2.0 * radius_m * height)), away = step > 0 ? step : 1.0 - step;
  const double end = 2.0 * sqrt(2.0 * radius_m * shift) * (sqrt(away) - sqrt(away - 1.0));
  if (height > top_m && altitude_m > top_m) return INFINITY; /* air that ends at its top, as dense as below: an edge */
  const double changes = expm1(2.0 * shift / height) + 4.0 * step_rad / sqrt(2.0 * height / radius_m);
  return fmin(changes + (way > 0.0 ? end / way : 0.0) + (air == airs ? 0.01 : 0.1) * tolerance, 1.0);
}

static void look_through_horizon(const extreme_air *air, const neph_sky *sky, double altitude_m, counts *c) {
  enum { STEPS = 200 };
  const double horizon = get_horizon(altitude_m);
  double all[2 * STEPS + 1][3], most = 0.0, ratio = 0.0;
  for (int i = 0; i <= 2 * STEPS; i++) {
    const np_dvec3 d = get_direction(horizon + (i - STEPS) * step_rad);
    neph_sky_get_radiance(sky, (const double[3]){d.x, d.y, d.z}, all[i]);
    assert_light(all[i], air->name, altitude_m);
    for (int b = 0; b < 3; b++) most = fmax(most, all[i][b]);
    c->rays++;
  }
  for (int i = 1; i <= 2 * STEPS && most > 0.0; i++) {
    const double allowed = get_allowed(air, altitude_m, i - STEPS) * most;
    for (int b = 0; b < 3 && (i < STEPS || i > STEPS + 2); b++)
      ratio = fmax(ratio, fabs(all[i][b] - all[i - 1][b]) / allowed);
  }
  if (!(ratio <= 1.0)) fail_msg("%s, %g m up: light jumps by %g of what it may", air->name, altitude_m, ratio);
  if (ratio <= c->worst_jump) return;
  c->worst_jump = ratio;
  (void)snprintf(c->worst_name, sizeof c->worst_name, "%s, %g m up", air->name, altitude_m);
}

/* Air between observer and points along rays, the light on level ground, and the zenith and the nadir. */
static void look_around(const extreme_air *air, const neph_sky *sky, double altitude_m, counts *c) {
  static const double distances_m[] = {0.0, 1e-3, 1.0, 1e3, 1e6, 1e9};
  double transmittance[3], light[3], sun[3];
  for (int i = 0; i <= 8; i++) {
    const np_dvec3 d = get_direction(NP_PI * i / 8.0);
    const double direction[3] = {d.x, d.y, d.z};
    for (size_t k = 0; k < sizeof distances_m / sizeof *distances_m; k++) {
      neph_sky_get_aerial_perspective(sky, direction, distances_m[k], transmittance, light);
      assert_share(transmittance, air->name, altitude_m);
      assert_light(light, air->name, altitude_m);
    }
    c->rays++;
  }
  neph_sky_get_irradiance(sky, sun, light);
  assert_light(sun, air->name, altitude_m);
  assert_light(light, air->name, altitude_m);
}

static void skies_are_bounded_and_smooth(void **state) {
  neph_context *context = *state;
  static const double suns_deg[] = {0.0, 90.0, 100.0};
  counts c = {0};
  double altitudes[ALTITUDES];
  fill_altitudes(altitudes);
  for (int n = 0; n < AIRS; n++) {
    neph_atmosphere *atmosphere = create_air(context, &airs[n], true);
    for (int h = 0; h < ALTITUDES; h++) {
      neph_sky *sky = test_sky_create(atmosphere, altitudes[h], suns_deg[(n + h) % 3]);
      look_through_horizon(&airs[n], sky, altitudes[h], &c);
      look_around(&airs[n], sky, altitudes[h], &c);
      neph_sky_destroy(sky);
      c.skies++;
    }
    neph_atmosphere_release(atmosphere);
  }
  test_page_add_figure(&page, "\n## Air\n");
  test_page_add_fact(&page, "%d airs from %d altitudes: %lu skies, %lu rays, steps of the view of %g rad.\n", AIRS,
                     ALTITUDES, c.skies, c.rays, step_rad);
  test_page_add_figure(&page, "The largest step of light through the horizon is %.2g of what the air allows: %s.\n",
                       c.worst_jump, c.worst_name);
}

/* ---- Transmittance ---- */

/* Towards a sun that sets: never brighter than a step before, and from higher up never darker, but for the
 * interpolation of tables, a hundredth of their tolerance, and black behind the planet. */
static void transmittance_is_monotone(void **state) {
  neph_context *context = *state;
  enum { STEPS = 400 };
  unsigned long count = 0;
  double altitudes[ALTITUDES];
  fill_altitudes(altitudes);
  for (int n = 0; n < AIRS; n++) {
    neph_atmosphere *atmosphere = create_air(context, &airs[n], false);
    for (int h = 0; h < ALTITUDES; h++) {
      double before[3] = {1.0, 1.0, 1.0};
      for (int i = -STEPS; i <= STEPS; i++) {
        const np_dvec3 d = get_direction(get_horizon(altitudes[h]) + i * step_rad);
        const double position[3] = {0.0, 0.0, altitudes[h]}, direction[3] = {d.x, d.y, d.z};
        double t[3];
        neph_atmosphere_get_transmittance(atmosphere, position, direction, t);
        assert_share(t, airs[n].name, altitudes[h]);
        for (int b = 0; b < 3; b++)
          if (t[b] > before[b] * (1.0 + 0.01 * tolerance) + 1e-6)
            fail_msg("%s, %g m up, step %d: the sun brightens from %g to %g as it sets", airs[n].name, altitudes[h], i,
                     before[b], t[b]);
        if (i > 2 && altitudes[h] > 0.0) assert_true(t[0] == 0.0 && t[1] == 0.0 && t[2] == 0.0);
        memcpy(before, t, sizeof before);
        count++;
      }
    }
    double below[3] = {0.0};
    for (int h = 0; h < ALTITUDES; h++) {
      const double position[3] = {0.0, 0.0, altitudes[h]}, direction[3] = {0.6, 0.0, 0.8};
      double t[3];
      neph_atmosphere_get_transmittance(atmosphere, position, direction, t);
      for (int b = 0; b < 3; b++) {
        assert_true(t[b] >= below[b] - 1e-6);
        if (altitudes[h] >= top_m) assert_true(t[b] == 1.0);
      }
      memcpy(below, t, sizeof below);
    }
    neph_atmosphere_release(atmosphere);
  }
  test_page_add_fact(&page, "Transmittance towards a setting sun is monotone over %lu steps of %g rad.\n", count,
                     step_rad);
}

/* ---- The sun ---- */

/* The sun sets by a millionth of a radian: light of the sky falls with the air's scale over its distance, 1e-6 / 0.02
 * rad at the horizon, and by the interpolation of tables. */
static void a_setting_sun_changes_little_by_little(void **state) {
  neph_context *context = *state;
  enum { SUNS = 12 };
  neph_atmosphere *atmosphere = create_air(context, &airs[0], true);
  const np_dvec3 d = test_direction(60.0, 90.0);
  const double direction[3] = {d.x, d.y, d.z};
  double before[3], worst = 0.0;
  for (int i = 0; i < SUNS; i++) {
    neph_sky *sky = test_sky_create(atmosphere, 2.0, 90.0 + (i - SUNS / 2) * step_rad / NP_DEGREE);
    double light[3];
    neph_sky_get_radiance(sky, direction, light);
    assert_light(light, "Earth", 2.0);
    for (int b = 0; b < 3 && i > 0; b++) worst = fmax(worst, fabs(light[b] / before[b] - 1.0));
    memcpy(before, light, sizeof before);
    neph_sky_destroy(sky);
  }
  test_page_add_figure(&page, "A sun that sets by %g rad changes the sky by %.2g at most.\n", step_rad, worst);
  assert_true(worst < 1e-3);
  neph_atmosphere_release(atmosphere);
}

/* ---- Refusals ---- */

static void refuse(neph_context *context, test_log *log, const char *input, test_air *air) {
  neph_atmosphere *atmosphere;
  assert_int_not_equal(neph_atmosphere_create(context, &air->desc, &atmosphere), NEPH_OK);
  assert_null(atmosphere);
  test_page_add_refusal(&page, input, log);
  test_air_start(air);
}

static void others_are_refused_with_a_message(void **state) {
  (void)state;
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  test_air air;
  test_air_start(&air);
  test_page_add_figure(&page, "| refused | message |\n| --- | --- |");
  air.layers[TEST_MOLECULES].height_m = 0.0;
  refuse(context, &log, "scale height 0", &air);
  air.layers[TEST_AEROSOL].scattering_per_m[1] = NAN;
  refuse(context, &log, "scattering NaN", &air);
  air.layers[TEST_AEROSOL].absorption_per_m[1] = -1e-9;
  refuse(context, &log, "absorption -1e-9", &air);
  air.layers[TEST_AEROSOL].asymmetry[2] = 1.0;
  refuse(context, &log, "asymmetry 1", &air);
  air.desc.planet_radius_m = 0.0;
  refuse(context, &log, "planet of radius 0", &air);
  air.desc.top_altitude_m = INFINITY;
  refuse(context, &log, "air without end", &air);
  air.desc.ground_albedo[0] = 1.5;
  refuse(context, &log, "ground albedo 1.5", &air);
  air.desc.tolerance = 0.0;
  refuse(context, &log, "tolerance 0", &air);
  neph_context_destroy(context);
}

static int set_up(void **state) {
  *state = test_context_create(2, NULL);
  return 0;
}

static int tear_down(void **state) {
  neph_context_destroy(*state);
  return 0;
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(skies_are_bounded_and_smooth),
      cmocka_unit_test(transmittance_is_monotone),
      cmocka_unit_test(a_setting_sun_changes_little_by_little),
      cmocka_unit_test(others_are_refused_with_a_message),
  };
  page = test_page_open(argc, argv);
  const int result = cmocka_run_group_tests(tests, set_up, tear_down);
  test_page_close(&page);
  return result;
}
