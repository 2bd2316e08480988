/* SPDX-License-Identifier: Apache-2.0 */
#include "test_skies.h"
#include "test_support.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"
#include "core/units.h"

enum { REFERENCE_MAX = 512 };

/* A row of tests/data/sky_reference.csv: radiance of all orders for a sun irradiance of 1, by Monte Carlo. */
typedef struct reference_row {
  double altitude_km, sun_deg, zenith_deg, azimuth_deg;
  int band;
  double radiance;
} reference_row;

static size_t read_reference(reference_row rows[REFERENCE_MAX]) {
  FILE *file = fopen(NEPHOS_TEST_SOURCE_DIR "/data/sky_reference.csv", "r");
  assert_non_null(file);
  char line[256];
  size_t count = 0;
  double first, second;
  while (fgets(line, sizeof line, file) && count < REFERENCE_MAX) {
    reference_row *r = &rows[count];
    if (sscanf(line, "%lf,%lf,%lf,%lf,%d,%lf,%lf,%lf", &r->altitude_km, &r->sun_deg, &r->zenith_deg, &r->azimuth_deg,
               &r->band, &first, &second, &r->radiance) == 8)
      count++;
  }
  fclose(file);
  assert_true(count > 300);
  return count;
}

static void set_direction(double zenith_deg, double azimuth_deg, double out[3]) {
  const double zenith = zenith_deg * NP_DEGREE, azimuth = azimuth_deg * NP_DEGREE;
  out[0] = sin(zenith) * cos(azimuth);
  out[1] = sin(zenith) * sin(azimuth);
  out[2] = cos(zenith);
}

/* A sky of irradiance 1 over an observer at an altitude, the sun's azimuth along x. */
static neph_sky *create_sky(neph_atmosphere *atmosphere, double altitude_m, double sun_zenith_deg) {
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  set_direction(sun_zenith_deg, 0.0, desc.sun_direction);
  for (int i = 0; i < 3; i++) desc.sun_irradiance_w_m2_nm[i] = 1.0;
  desc.observer_m[2] = altitude_m;
  neph_sky *sky = NULL;
  assert_int_equal(neph_sky_create(atmosphere, &desc, &sky), NEPH_OK);
  return sky;
}

/* Compares the rows of one altitude and sun, which follow each other, and prints the outcome; returns how many they
 * were. Tolerances: 2 % for a sun above the horizon and 4 % below it are this stage's gates; measured 0.2 to 0.6 % and
 * 0.9 %. */
static size_t compare_block(neph_atmosphere *atmosphere, const reference_row *rows, size_t count) {
  neph_sky *sky = create_sky(atmosphere, rows->altitude_km * NP_KILOMETRE, rows->sun_deg);
  double square[3] = {0}, sum[3] = {0};
  int band_count[3] = {0};
  size_t i = 0;
  for (; i < count && rows[i].sun_deg == rows->sun_deg && rows[i].altitude_km == rows->altitude_km; i++) {
    double direction[3], radiance[3];
    set_direction(rows[i].zenith_deg, rows[i].azimuth_deg, direction);
    neph_sky_get_radiance(sky, direction, radiance);
    const double error = radiance[rows[i].band] / rows[i].radiance - 1.0;
    square[rows[i].band] += error * error;
    sum[rows[i].band] += error;
    band_count[rows[i].band]++;
  }
  for (int b = 0; b < 3; b++) {
    const double rms = sqrt(square[b] / band_count[b]);
    print_message("sky at %g km, sun zenith %g deg, band %d: rel-rms %.2f %%, bias %+.2f %%\n", rows->altitude_km,
                  rows->sun_deg, b, 100.0 * rms, 100.0 * sum[b] / band_count[b]);
    assert_true(rms <= (rows->sun_deg > 90.0 ? 0.04 : 0.02));
  }
  neph_sky_destroy(sky);
  return i;
}

static void radiance_agrees_with_monte_carlo(void **state) {
  const neph_atmosphere *earth = *state;
  neph_atmosphere *atmosphere = NULL; /* its sun a point, as the rows have it */
  test_air air;
  test_air_start(&air);
  test_air_set_one_lobe(&air);
  assert_int_equal(np_atmosphere_create_orders(earth->context, &air.desc, NP_ORDERS_ALL, true, NULL, &atmosphere),
                   NEPH_OK);
  reference_row rows[REFERENCE_MAX];
  const size_t count = read_reference(rows);
  for (size_t i = 0; i < count;) i += compare_block(atmosphere, rows + i, count - i);
  neph_atmosphere_release(atmosphere);
}

static np_vec3 direction_of(double zenith_deg, double azimuth_deg) {
  double d[3];
  set_direction(zenith_deg, azimuth_deg, d);
  return np_vec3_make((float)d[0], (float)d[1], (float)d[2]);
}

static void assert_light(np_spectrum s) {
  for (int b = 0; b < NP_BAND_COUNT; b++) assert_true(isfinite(s.band[b]) && s.band[b] >= 0.0f);
}

static void assert_bands_near(np_spectrum actual, np_spectrum expected, double tolerance) {
  for (int b = 0; b < NP_BAND_COUNT; b++)
    assert_near_relative((double)actual.band[b], (double)expected.band[b], tolerance);
}

/* ---- Continuity ---- */

/* Along a meridian of each side of the horizon, 0.0125° at a time: the steepest that a clear sky gets is the limb,
 * where that is 18 m of height at the horizon's distance, and 1.5 % in the aerosol's density; the aureole falls by at
 * most 2.2 %, and the twilight arch from 12 km turns 3 %. A wrong side of the horizon would be more. Just below the
 * horizon a ray's length, and its light with it, falls as the inverse of the angle: a degree of that is left out. */
static void scan_meridian(const neph_sky *sky, double altitude_m, double azimuth_deg) {
  const double horizon_deg = 90.0 + acos(6360e3 / (6360e3 + altitude_m)) / NP_DEGREE;
  np_spectrum before = np_spectrum_grey(0.0f);
  for (int i = 0; i <= 4 * 3600; i++) {
    const double zenith = 0.0125 * i;
    const np_spectrum here = np_sky_radiance(sky, direction_of(zenith, azimuth_deg));
    assert_light(here);
    const bool crosses = zenith > horizon_deg - 0.06 && zenith < horizon_deg + 1.0;
    if (i > 0 && !crosses) assert_bands_near(here, before, 0.06);
    before = here;
  }
}

static void radiance_has_no_seams_along_meridians(void **state) {
  const double altitudes[] = {2.0, 500.0, 12000.0}, suns[] = {30.0, 87.0, 94.0};
  for (int i = 0; i < 3; i++) {
    neph_sky *sky = create_sky(*state, altitudes[i], suns[i]);
    scan_meridian(sky, altitudes[i], 0.0);
    scan_meridian(sky, altitudes[i], 90.0);
    scan_meridian(sky, altitudes[i], 180.0);
    neph_sky_destroy(sky);
  }
}

/* Around the horizon, over the seam opposite the sun and the one at it: 0.0125° at a time, no step beyond 3 %, of which
 * the aureole of a low sun has 2; mirrored azimuths agree to rounding. */
static void radiance_has_no_seams_around_the_horizon(void **state) {
  neph_sky *sky = create_sky(*state, 500.0, 87.0);
  np_spectrum before = np_sky_radiance(sky, direction_of(89.0, -0.0125));
  for (int i = 0; i <= 20 * 1440; i++) {
    const np_spectrum here = np_sky_radiance(sky, direction_of(89.0, 0.0125 * i));
    assert_bands_near(here, before, 0.03);
    assert_bands_near(here, np_sky_radiance(sky, direction_of(89.0, -0.0125 * i)), 1e-4);
    before = here;
  }
  neph_sky_destroy(sky);
}

/* Altitudes at which the tables change their rules: a step of 0.2 % in it must change nothing: 0.5 %,
 * which is what the quadratures on either side differ by at the most. */
static void radiance_is_continuous_in_altitude(void **state) {
  const double thresholds[] = {300.0, 3000.0, 10000.0, 50000.0, 100000.0};
  for (int i = 0; i < 5; i++) {
    neph_sky *below = create_sky(*state, 0.999 * thresholds[i], 80.0);
    neph_sky *above = create_sky(*state, 1.001 * thresholds[i], 80.0);
    for (int zenith = 95; zenith <= 175; zenith += 10) {
      if (zenith == 95 && thresholds[i] > 20000.0) continue; /* still above the horizon's dip: the limb itself moves */
      const np_vec3 d = direction_of(zenith, 70.0);
      assert_bands_near(np_sky_radiance(above, d), np_sky_radiance(below, d), 0.005);
    }
    neph_sky_destroy(below);
    neph_sky_destroy(above);
  }
}

/* Sun from half a degree above to half a degree below the horizon, 0.1° at a time: light only falls, and never by more
 * than a fifth a step (the disk itself, 0.53° wide, apart). */
static void sunset_is_smooth(void **state) {
  np_spectrum before = np_spectrum_grey(1.0f);
  for (int i = 0; i <= 10; i++) {
    neph_sky *sky = create_sky(*state, 100.0, 89.5 + 0.1 * i);
    const np_spectrum here = np_sky_radiance(sky, direction_of(45.0, 90.0));
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      assert_true(here.band[b] < before.band[b]);
      if (i > 0) assert_true(here.band[b] > 0.8f * before.band[b]);
    }
    before = here;
    neph_sky_destroy(sky);
  }
}

/* Dusk fades into nothing by 21° below the horizon, and what is left is finite and not negative on the way. */
static void night_is_dark(void **state) {
  const double suns[] = {100.0, 106.0, 108.0, 112.0, 135.0, 180.0};
  for (int i = 0; i < 6; i++) {
    neph_sky *sky = create_sky(*state, 200.0, suns[i]);
    for (int zenith = 0; zenith <= 180; zenith += 5) {
      const np_spectrum here = np_sky_radiance(sky, direction_of(zenith, 3.0 * zenith));
      assert_light(here);
      /* Full day is 0.01 to 0.1; the darkest sky that a camera can see, 1e-9 of it. */
      if (suns[i] >= 112.0) assert_true(np_spectrum_max(here) < 1e-11f);
    }
    neph_sky_destroy(sky);
  }
}

/* ---- Observers ---- */

/* Under the zenith sun there is no azimuth: what the tables keep of it must not show. 0.1 %: the rows' rounding. */
static void sun_at_the_zenith_leaves_no_azimuth(void **state) {
  neph_sky *sky = create_sky(*state, 500.0, 0.0);
  for (int zenith = 5; zenith < 180; zenith += 10) {
    if (zenith == 95) continue;
    const np_spectrum first = np_sky_radiance(sky, direction_of(zenith, 0.0));
    for (int azimuth = 30; azimuth < 360; azimuth += 30)
      assert_bands_near(np_sky_radiance(sky, direction_of(zenith, azimuth)), first, 1e-3);
  }
  neph_sky_destroy(sky);
}

/* Below the sea an observer sees what one at its surface sees. */
static void observers_below_the_sea_are_at_its_level(void **state) {
  neph_sky *below = create_sky(*state, -430.0, 40.0), *at = create_sky(*state, 0.0, 40.0);
  for (int zenith = 0; zenith < 90; zenith += 10)
    assert_bands_near(np_sky_radiance(below, direction_of(zenith, 50.0)),
                      np_sky_radiance(at, direction_of(zenith, 50.0)), 1e-5);
  /* A hill's foot, in the valley with the observer: air between as anywhere at sea level. */
  const np_aerial_perspective ap = np_sky_aerial_perspective(below, direction_of(92.0, 50.0), 5000.0);
  assert_light(ap.inscatter);
  /* exp(−5 km · (5.802 + 4.44)e-6/m) = 0.950, in red; ozone and the slope stay under 1 %. */
  assert_near((double)ap.transmittance.band[0], 0.950, 0.01);
  neph_sky_destroy(below);
  neph_sky_destroy(at);
}

static void rays_from_space_meet_the_air_or_miss_it(void **state) {
  const double altitudes[] = {400e3, 36e6, 384e6};
  for (int i = 0; i < 3; i++) {
    const double r = 6360e3 + altitudes[i];
    const double top_deg = 180.0 - asin(6460e3 / r) / NP_DEGREE, horizon_deg = 180.0 - asin(6360e3 / r) / NP_DEGREE;
    neph_sky *sky = create_sky(*state, altitudes[i], 50.0);
    const np_vec3 past = direction_of(top_deg - 0.01, 20.0);
    const np_vec3 limb = direction_of(0.1 * top_deg + 0.9 * horizon_deg, 20.0);
    assert_true(np_spectrum_is_zero(np_sky_radiance(sky, past)));
    assert_true(np_spectrum_is_zero(np_sky_aerial_perspective(sky, past, 1e9).inscatter));
    assert_near((double)np_sky_aerial_perspective(sky, past, 1e9).transmittance.band[0], 1.0, 0.0);
    assert_true(np_sky_radiance(sky, limb).band[2] > 1e-3f);
    assert_true(np_sky_radiance(sky, direction_of(180.0, 0.0)).band[2] > 1e-3f);
    /* Before the ray has entered there is nothing; at the ground, the vertical depth of the red band, 0.058. */
    const np_vec3 nadir = direction_of(180.0, 0.0);
    assert_true(np_spectrum_is_zero(np_sky_aerial_perspective(sky, nadir, altitudes[i] - 101e3).inscatter));
    assert_near((double)np_sky_aerial_perspective(sky, nadir, altitudes[i]).transmittance.band[0], exp(-0.0615), 0.002);
    neph_sky_destroy(sky);
  }
}

/* ---- Aerial perspective ---- */

/* Farther is dimmer, for every direction; and in-scatter, between the slices as at them, only grows. */
static void farther_is_dimmer(void **state) {
  neph_sky *sky = create_sky(*state, 1500.0, 75.0);
  for (int zenith = 1; zenith < 180; zenith += 3) {
    np_aerial_perspective before = np_sky_aerial_perspective(sky, direction_of(zenith, 40.0), 0.0);
    assert_near((double)before.transmittance.band[2], 1.0, 0.0);
    for (double distance = 10.0; distance < 2e6; distance *= 1.1) {
      const np_aerial_perspective here = np_sky_aerial_perspective(sky, direction_of(zenith, 40.0), distance);
      for (int b = 0; b < NP_BAND_COUNT; b++) {
        assert_true(here.transmittance.band[b] <= before.transmittance.band[b]);
        /* Tolerance: rounding of a float sum of 30 terms. */
        assert_true(here.inscatter.band[b] >= before.inscatter.band[b] * (1.0f - 4e-6f));
      }
      before = here;
    }
  }
  neph_sky_destroy(sky);
}

/* Both tables hold the same light up to the end of the air: 1 %. Never is a ray without end, or one that is no number.
 * */
static void far_end_is_the_sky(void **state) {
  neph_sky *sky = create_sky(*state, 500.0, 60.0);
  for (int zenith = 0; zenith <= 90; zenith += 5)
    for (int azimuth = 0; azimuth <= 180; azimuth += 45) {
      const np_vec3 d = direction_of(zenith, azimuth);
      assert_bands_near(np_sky_aerial_perspective(sky, d, 3e6).inscatter, np_sky_radiance(sky, d), 0.01);
    }
  assert_light(np_sky_aerial_perspective(sky, direction_of(120.0, 0.0), INFINITY).inscatter);
  assert_light(np_sky_aerial_perspective(sky, direction_of(120.0, 0.0), (double)NAN).inscatter);
  neph_sky_destroy(sky);
}

/* Users would first see a line at the horizon on objects there. Things 20 km away just above and just below
 * it are behind the same air: 1 %. */
static void no_line_at_the_horizon(void **state) {
  neph_sky *sky = create_sky(*state, 500.0, 80.0);
  const double horizon = 90.0 + acos(6360.0 / 6360.5) / NP_DEGREE;
  for (int azimuth = 0; azimuth <= 180; azimuth += 20) {
    const np_aerial_perspective above = np_sky_aerial_perspective(sky, direction_of(horizon - 0.005, azimuth), 20000.0);
    const np_aerial_perspective below = np_sky_aerial_perspective(sky, direction_of(horizon + 0.005, azimuth), 20000.0);
    assert_bands_near(below.inscatter, above.inscatter, 0.01);
    assert_bands_near(below.transmittance, above.transmittance, 0.005);
  }
  neph_sky_destroy(sky);
}

/* The table against the march between the same two points: 0.3 %, a third of what one would see as a step. */
static void table_transmits_as_the_march_does(void **state) {
  neph_sky *sky = create_sky(*state, 800.0, 60.0);
  const np_dvec3 observer = sky->observer;
  for (int zenith = 10; zenith <= 90; zenith += 10)
    for (double distance = 500.0; distance < 100e3; distance *= 3.0) {
      const np_vec3 d = direction_of(zenith, 10.0);
      const np_spectrum marched =
          np_atmosphere_transmittance_between(*state, observer, np_dvec3_along(observer, d, distance));
      assert_bands_near(np_sky_aerial_perspective(sky, d, distance).transmittance, marched, 0.003);
    }
  neph_sky_destroy(sky);
}

/* ---- Energy ---- */

/* Sky light on level ground, once from the sky view and once from the moments' own sum over orders: two ways to the
 * same flux that share the later orders only in part. 1.5 %, and 4 % once the ground is dark and the light comes from
 * afar. */
static void compare_irradiance(neph_atmosphere *atmosphere, double altitude_m, double sun_deg, double most) {
  neph_sky *sky = create_sky(atmosphere, altitude_m, sun_deg);
  double sun[3], ground[3];
  neph_sky_get_irradiance(sky, sun, ground);
  const np_spectrum table = np_atmosphere_ground_irradiance(atmosphere, altitude_m, (float)cos(sun_deg * NP_DEGREE));
  print_message("sky irradiance at %g m, sun zenith %g deg: table over integral %+.2f %+.2f %+.2f %%\n", altitude_m,
                sun_deg, 100.0 * ((double)table.band[0] / ground[0] - 1.0),
                100.0 * ((double)table.band[1] / ground[1] - 1.0), 100.0 * ((double)table.band[2] / ground[2] - 1.0));
  for (int b = 0; b < 3; b++) assert_near_relative((double)table.band[b], ground[b], most);
  neph_sky_destroy(sky);
}

static void irradiance_is_the_integral_of_radiance(void **state) {
  const double suns[] = {0.0, 40.0, 70.0, 85.0, 90.0, 94.0};
  for (int i = 0; i < 6; i++) compare_irradiance(*state, 0.0, suns[i], suns[i] < 90.0 ? 0.015 : 0.04);
}

/* Mountains have no light from the haze below them. Where sea level stood for them, ground at 700 m
 * had 1.1 times its red skylight in this air, at 4 km 1.8 times. */
static void mountains_have_their_own_skylight(void **state) {
  const double altitudes_m[] = {300.0, 700.0, 2000.0, 4000.0};
  for (int i = 0; i < 4; i++)
    for (double sun_deg = 0.0; sun_deg < 90.0; sun_deg += 40.0)
      compare_irradiance(*state, altitudes_m[i], sun_deg, 0.025);
}

/* ---- Objects ---- */

static neph_sky *create_sky_with(unsigned threads, neph_isa isa) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = threads;
  desc.isa_max = isa;
  neph_context *context = NULL;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, NULL, &atmosphere), NEPH_OK);
  neph_sky *sky = create_sky(atmosphere, 700.0, 72.0);
  neph_atmosphere_release(atmosphere);
  neph_context_destroy(context);
  return sky;
}

/* Instruction sets too: the tables' kernels do in each lane what they would do in one alone. */
static void same_bits_for_any_thread_count_and_instruction_set(void **state) {
  (void)state;
  neph_sky *first = create_sky_with(1, NEPH_ISA_X86_64_V4);
  neph_sky *others[] = {create_sky_with(3, NEPH_ISA_X86_64_V4), create_sky_with(1, NEPH_ISA_X86_64_V3),
                        create_sky_with(1, NEPH_ISA_X86_64)};
  for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
    for (int zenith = 1; zenith < 180; zenith++) {
      const np_vec3 d = direction_of(zenith, 2.0 * zenith);
      const np_spectrum a = np_sky_radiance(first, d), b = np_sky_radiance(others[i], d);
      assert_memory_equal(&a, &b, sizeof a);
      const np_aerial_perspective c = np_sky_aerial_perspective(first, d, 3000.0);
      const np_aerial_perspective e = np_sky_aerial_perspective(others[i], d, 3000.0);
      assert_memory_equal(&c, &e, sizeof c);
    }
    neph_sky_destroy(others[i]);
  }
  neph_sky_destroy(first);
}

static neph_result attempt_sky(neph_context *context, void *user) {
  (void)user;
  neph_atmosphere *atmosphere = NULL;
  neph_sky *sky = NULL;
  neph_result result = neph_atmosphere_create(context, NULL, &atmosphere);
  if (!result) result = neph_sky_create(atmosphere, NULL, &sky);
  if (result) assert_null(sky);
  neph_sky_destroy(sky);
  neph_atmosphere_release(atmosphere);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt_sky, NULL);
}

static void wrong_descriptions_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, NULL, &atmosphere), NEPH_OK);
  neph_sky *sky = NULL;
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  desc.sun_direction[2] = 2.0;
  assert_int_equal(neph_sky_create(atmosphere, &desc, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "sun_direction", "(0, 0, 2)", "unit");
  desc = (neph_sky_desc)NEPH_SKY_DESC_DEFAULT;
  desc.sun_irradiance_w_m2_nm[1] = -1.0;
  assert_int_equal(neph_sky_create(atmosphere, &desc, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "sun_irradiance", "-1", "at least 0");
  desc = (neph_sky_desc)NEPH_SKY_DESC_DEFAULT;
  desc.sun_angular_radius_rad = 3.0;
  assert_int_equal(neph_sky_create(atmosphere, &desc, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "sun_angular_radius_rad", "3", "[0, 0.5]");
  desc = (neph_sky_desc)NEPH_SKY_DESC_DEFAULT;
  desc.observer_m[0] = (double)NAN;
  assert_int_equal(neph_sky_create(atmosphere, &desc, &sky), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "observer_m", "nan", "finite");
  assert_null(sky);
  neph_atmosphere_release(atmosphere);
  neph_context_destroy(context);
}

static int create_earth(void **state) {
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, NULL, &atmosphere), NEPH_OK);
  neph_context_destroy(context);
  *state = atmosphere;
  return 0;
}

static int release_earth(void **state) {
  neph_atmosphere_release(*state);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(radiance_agrees_with_monte_carlo),
      cmocka_unit_test(radiance_has_no_seams_along_meridians),
      cmocka_unit_test(radiance_has_no_seams_around_the_horizon),
      cmocka_unit_test(radiance_is_continuous_in_altitude),
      cmocka_unit_test(sunset_is_smooth),
      cmocka_unit_test(night_is_dark),
      cmocka_unit_test(sun_at_the_zenith_leaves_no_azimuth),
      cmocka_unit_test(observers_below_the_sea_are_at_its_level),
      cmocka_unit_test(rays_from_space_meet_the_air_or_miss_it),
      cmocka_unit_test(farther_is_dimmer),
      cmocka_unit_test(far_end_is_the_sky),
      cmocka_unit_test(no_line_at_the_horizon),
      cmocka_unit_test(table_transmits_as_the_march_does),
      cmocka_unit_test(irradiance_is_the_integral_of_radiance),
      cmocka_unit_test(mountains_have_their_own_skylight),
      cmocka_unit_test(same_bits_for_any_thread_count_and_instruction_set),
      cmocka_unit_test(failed_allocations_leave_nothing),
      cmocka_unit_test(wrong_descriptions_are_refused),
  };
  return cmocka_run_group_tests(tests, create_earth, release_earth);
}
