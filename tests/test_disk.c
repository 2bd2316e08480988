/* SPDX-License-Identifier: Apache-2.0 */
/* Disks of sun and moon: known brightness, and flux that no shading changes. */
#include "test_support.h"

#include "atmosphere/moon.h"
#include "core/units.h"

static const double bands_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};
static const double sun_radius = 0.2678 * NP_DEGREE;
static const double moon_radius = 0.258966 * NP_DEGREE; /* asin(1737.4 km/384,400 km) */

/* Irradiance of a disk on a plane facing it: midpoints in the squared sine and the angle about the centre. Limb
 * darkening falls as a root at the edge, where the rule's error goes with the power 3/2 of the rings' number. */
static void integrate(const np_disk *disk, double radius, int rings, int azimuth_count, double out[NP_BAND_COUNT]) {
  np_vec3 a, b;
  np_frame_around(disk->direction, &a, &b);
  for (int c = 0; c < NP_BAND_COUNT; c++) out[c] = 0.0;
  const double sine = sin(radius);
  for (int i = 0; i < rings; i++)
    for (int k = 0; k < azimuth_count; k++) {
      const double s = sine * sqrt((i + 0.5) / rings), turn = 2.0 * NP_PI * (k + 0.5) / azimuth_count;
      const np_vec3 x = np_vec3_scale(a, (float)(s * cos(turn))), y = np_vec3_scale(b, (float)(s * sin(turn)));
      const np_vec3 z = np_vec3_scale(disk->direction, (float)sqrt(1.0 - s * s));
      const np_spectrum radiance = np_disk_radiance(disk, np_vec3_add(z, np_vec3_add(x, y)));
      for (int c = 0; c < NP_BAND_COUNT; c++)
        out[c] += (double)radiance.band[c] * NP_PI * sine * sine / ((double)rings * azimuth_count);
    }
}

/* ---- The sun ---- */

/* Exactly: the coefficients' own integral, in which 1e-6 is rounding of floats; and by looking at the disk, along the
 * axes where directions are exact, to what the rule and float directions leave of it. */
static void limb_darkening_keeps_the_irradiance(void **state) {
  (void)state;
  const np_spectrum irradiance = np_spectrum_make(1.474f, 1.8504f, 1.91198f);
  const np_disk disk = np_disk_make_sun(np_vec3_make(0, 0, 1), sun_radius, irradiance, bands_nm);
  double seen[NP_BAND_COUNT];
  integrate(&disk, sun_radius, 20000, 4, seen);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double sum = 0.0;
    for (int k = 0; k < NP_LIMB_TERMS; k++) sum += 2.0 * (double)disk.limb[b][k] / (k + 2);
    const double flux = (double)disk.radiance.band[b] * sum * NP_PI * sin(sun_radius) * sin(sun_radius);
    assert_near_relative(flux, (double)irradiance.band[b], 1e-6);
    assert_near_relative(seen[b], (double)irradiance.band[b], 2e-5);
  }
}

/* The very edge of the sun has a third of the centre's brightness in red, and a sixth in blue (Neckel and Labs 1994,
 * figure 1). */
static void the_limb_is_dark_and_red(void **state) {
  (void)state;
  double red[NP_LIMB_TERMS], blue[NP_LIMB_TERMS];
  np_limb_darkening(680.0, red);
  np_limb_darkening(440.0, blue);
  double at_centre = 0.0;
  for (int k = 0; k < NP_LIMB_TERMS; k++) at_centre += red[k];
  assert_near(at_centre, 1.0, 1e-9); /* exact by construction of the fit, to its five digits */
  assert_true(red[0] > 0.3 && blue[0] < 0.2);
  const np_disk disk = np_disk_make_sun(np_vec3_make(0, 0, 1), sun_radius, np_spectrum_grey(1.0f), bands_nm);
  const np_spectrum centre = np_disk_radiance(&disk, np_vec3_make(0, 0, 1));
  const float s = (float)sin(0.99 * sun_radius);
  const np_spectrum limb = np_disk_radiance(&disk, np_vec3_make(s, 0, sqrtf(1.0f - s * s)));
  for (int b = 0; b < NP_BAND_COUNT; b++) assert_true(limb.band[b] < 0.6f * centre.band[b]);
  assert_true(limb.band[0] / centre.band[0] > 1.3f * limb.band[2] / centre.band[2]);
}

static void beside_the_disk_is_nothing(void **state) {
  (void)state;
  const np_disk disk = np_disk_make_sun(np_vec3_make(0, 0, 1), sun_radius, np_spectrum_grey(1.0f), bands_nm);
  const float inside = (float)sin(0.999 * sun_radius), outside = (float)sin(1.001 * sun_radius);
  assert_true(np_disk_covers(&disk, np_vec3_make(0, inside, sqrtf(1.0f - inside * inside))));
  assert_false(np_disk_covers(&disk, np_vec3_make(0, outside, sqrtf(1.0f - outside * outside))));
  assert_false(np_disk_covers(&disk, np_vec3_make(0, 0, -1)));
  const np_disk point = np_disk_make(np_vec3_make(0, 0, 1), 0.0, np_spectrum_grey(1.0f));
  assert_false(np_disk_covers(&point, np_vec3_make(0, 0, 1)));
  assert_true(np_spectrum_is_zero(np_disk_radiance(&point, np_vec3_make(0, 0, 1))));
}

/* ---- The moon ---- */

/* A moon at the zenith whose sun stands at an angle from it, towards x. */
static np_moon_place moon_at_elongation(double degrees) {
  const double e = degrees * NP_DEGREE;
  return np_moon_place_between(np_dvec3_make(0, 0, 1), np_dvec3_make(sin(e), 0, cos(e)));
}

/* −12.73 against −26.74 magnitudes: 1/402,000. Krisciunas and Schaefer give a full moon at the zenith 0.267 lx beneath
 * air that takes 0.172 magnitudes, with the sun's 128,000 lx outside it. */
static void the_full_moon_is_four_hundred_thousand_times_fainter_than_the_sun(void **state) {
  (void)state;
  const np_moon_place full = moon_at_elongation(180.0);
  assert_near(np_celestial_phase_angle(&full), 0.0, 1e-9);
  const double ratio = np_moon_irradiance_ratio(&full, 550.0);
  assert_near_relative(1.0 / ratio, 402000.0, 0.01);
  assert_near_relative(128000.0 * ratio * pow(10.0, -0.4 * 0.172), 0.267, 0.03);
  /* B − V 0.27 above the sun's. */
  assert_near_relative(np_moon_irradiance_ratio(&full, 440.0) / ratio, pow(10.0, -0.4 * 0.27), 0.01);
}

/* Allen's curve: 2.60 magnitudes down at the quarter, which is not a half but an eleventh of the full moon. */
static void phases_follow_the_measured_curve(void **state) {
  (void)state;
  assert_near(np_moon_phase_factor(0.0), 1.0, 1e-12);
  assert_near_relative(np_moon_phase_factor(0.5 * NP_PI), pow(10.0, -0.4 * 2.6024), 1e-4);
  double before = 2.0;
  for (int degrees = 0; degrees <= 180; degrees++) {
    const double factor = np_moon_phase_factor(degrees * NP_DEGREE);
    assert_true(factor >= 0.0 && factor < before);
    before = factor;
  }
  assert_true(before < 1e-6);
}

/* The Lommel-Seeliger integral is exact; a 256² rule meets its terminator to 1e-3. */
static void the_disk_adds_up_to_its_magnitude(void **state) {
  (void)state;
  for (int degrees = 20; degrees <= 180; degrees += 40)
    for (int earthshine = 0; earthshine < 2; earthshine++) {
      const np_moon_place moon = moon_at_elongation(degrees);
      np_spectrum irradiance;
      const np_disk disk = np_moon_make_disk(&moon, np_spectrum_grey(1.0f), bands_nm, earthshine, NULL, &irradiance);
      double seen[NP_BAND_COUNT];
      integrate(&disk, moon_radius, 256, 256, seen);
      for (int b = 0; b < NP_BAND_COUNT; b++) assert_near_relative(seen[b], (double)irradiance.band[b], 5e-3);
      if (!earthshine) assert_near_relative((double)irradiance.band[1], np_moon_irradiance_ratio(&moon, 550.0), 1e-5);
    }
}

static float brightness_at(const np_disk *disk, double x, double y) {
  const double s = sin(moon_radius);
  return np_disk_radiance(disk, np_vec3_normalize(np_vec3_make((float)(s * x), (float)(s * y), 1.0f))).band[1];
}

/* A quarter moon shines on the side of the sun alone; a full one is even, which no Lambert sphere is. */
static void the_bright_side_faces_the_sun(void **state) {
  (void)state;
  np_spectrum irradiance;
  const np_moon_place quarter = moon_at_elongation(90.0), full = moon_at_elongation(180.0);
  const np_disk half = np_moon_make_disk(&quarter, np_spectrum_grey(1.0f), bands_nm, false, NULL, &irradiance);
  assert_true(brightness_at(&half, 0.5, 0.0) > 0.0f);
  assert_near((double)brightness_at(&half, -0.5, 0.0), 0.0, 0.0);
  assert_true(brightness_at(&half, 0.9, 0.0) > brightness_at(&half, 0.1, 0.0));
  const np_disk even = np_moon_make_disk(&full, np_spectrum_grey(1.0f), bands_nm, false, NULL, &irradiance);
  assert_near_relative((double)brightness_at(&even, 0.95, 0.0), (double)brightness_at(&even, 0.0, 0.0), 1e-3);
}

/* The dark side of a thin crescent: the Earth, seen from there four times as wide as the moon from here and five times
 * as white, is 80 times a full moon; what it lights has a ten-thousandth of the full moon's radiance. */
static void earthshine_lights_the_dark_side(void **state) {
  (void)state;
  np_spectrum irradiance;
  const np_moon_place crescent = moon_at_elongation(20.0), full = moon_at_elongation(180.0);
  const np_disk dark = np_moon_make_disk(&crescent, np_spectrum_grey(1.0f), bands_nm, true, NULL, &irradiance);
  const np_disk bright = np_moon_make_disk(&full, np_spectrum_grey(1.0f), bands_nm, true, NULL, &irradiance);
  const double ratio = (double)brightness_at(&dark, -0.5, 0.0) / (double)brightness_at(&bright, 0.0, 0.0);
  assert_true(ratio > 0.5e-4 && ratio < 1.2e-4);
}

/* A map puts its pattern on the disk by the moon's own longitudes, east to the right from the north, and takes nothing
 * from its flux, by the same sum that normalizes it: rounding. */
static void a_map_changes_the_pattern_and_not_the_flux(void **state) {
  (void)state;
  np_spectrum texels[8], irradiance, plain;
  for (int i = 0; i < 8; i++) texels[i] = np_spectrum_grey(i % 4 == 2 ? 3.0f : 1.0f); /* longitudes 0 to 90 east */
  const np_sphere_map map = {.width = 4, .height = 2, .texels = texels, .east = 1.0f};
  /* Camera to the south, so that its north is up and its east, where its sun rises, is to the west of the sky. */
  const np_moon_place moon = np_moon_place_between(np_dvec3_make(0, -1, 0), np_dvec3_make(0, 1, 0));
  const np_disk disk = np_moon_make_disk(&moon, np_spectrum_grey(1.0f), bands_nm, false, &map, &irradiance);
  (void)np_moon_make_disk(&moon, np_spectrum_grey(1.0f), bands_nm, false, NULL, &plain);
  assert_near((double)irradiance.band[1], (double)plain.band[1], 0.0);
  double seen[NP_BAND_COUNT];
  integrate(&disk, moon_radius, 256, 256, seen);
  assert_near_relative(seen[1], (double)plain.band[1], 2e-3); /* 128² points of the sum meet the edge to that */
  const float s = (float)(0.5 * sin(moon_radius));
  const np_spectrum west = np_disk_radiance(&disk, np_vec3_normalize(np_vec3_make(-s, -1, 0)));
  const np_spectrum east = np_disk_radiance(&disk, np_vec3_normalize(np_vec3_make(s, -1, 0)));
  assert_true(west.band[1] > 1.5f * east.band[1]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(limb_darkening_keeps_the_irradiance),
      cmocka_unit_test(the_limb_is_dark_and_red),
      cmocka_unit_test(beside_the_disk_is_nothing),
      cmocka_unit_test(the_full_moon_is_four_hundred_thousand_times_fainter_than_the_sun),
      cmocka_unit_test(phases_follow_the_measured_curve),
      cmocka_unit_test(the_disk_adds_up_to_its_magnitude),
      cmocka_unit_test(the_bright_side_faces_the_sun),
      cmocka_unit_test(earthshine_lights_the_dark_side),
      cmocka_unit_test(a_map_changes_the_pattern_and_not_the_flux),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
