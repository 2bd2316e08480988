/* SPDX-License-Identifier: Apache-2.0 */
/* Stars, magnitudes, airglow, maps of the sphere. */
#include "test_nights.h"

#include "atmosphere/airglow.h"
#include "atmosphere/magnitudes.h"
#include "atmosphere/sphere_map.h"
#include "atmosphere/stars.h"

/* ---- Light ---- */

/* A star has its magnitudes at the centres of B and V, by construction; a black body through both is 6 % from Vega in
 * red, 1.85e-11 at 680 nm (Bohlin 2014). Betelgeuse outshines Rigel there, and not in blue. */
static void a_star_has_its_magnitudes(void **state) {
  (void)state;
  const double middles[NP_BAND_COUNT] = {438.0, 545.0, 680.0};
  const np_spectrum vega = np_star_irradiance(0.03, 0.0, middles);
  assert_near_relative((double)vega.band[0], 6.32e-11 * pow(10.0, -0.4 * 0.03), 1e-5);
  assert_near_relative((double)vega.band[1], 3.631e-11 * pow(10.0, -0.4 * 0.03), 1e-5);
  assert_near_relative((double)vega.band[2], 1.85e-11, 0.1);
  const np_spectrum red = np_star_irradiance(0.50, 1.85, bands_nm), blue = np_star_irradiance(0.12, -0.03, bands_nm);
  assert_true(red.band[0] > 1.5f * blue.band[0] && red.band[2] < 0.3f * blue.band[2]);
  /* The sun, as a star of magnitude −26.74 and colour 0.65. */
  const np_spectrum sun = np_star_irradiance(-26.74, 0.65, bands_nm);
  assert_near_relative((double)sun.band[1], 1.85, 0.05);
  assert_near_relative((double)sun.band[0], 1.474, 0.05);
  /* Colours that no star has stay finite. */
  for (int c = -5; c <= 10; c += 15) {
    const np_spectrum odd = np_star_irradiance(1.0, c, bands_nm);
    for (int b = 0; b < NP_BAND_COUNT; b++) assert_true(isfinite(odd.band[b]) && odd.band[b] >= 0.0f);
  }
}

/* 21.9 V magnitudes a square arc second: 2.7e-9 W/m2/sr/nm. */
static void airglow_has_its_brightness_and_brightens_to_the_horizon(void **state) {
  (void)state;
  const double radius = 6371e3;
  const np_airglow glow = np_airglow_make(21.9, radius, 90e3, bands_nm);
  const np_spectrum up = np_airglow_radiance(&glow, np_dvec3_make(0, 0, 0), np_vec3_make(0, 0, 1));
  const double arc_second = NP_DEGREE / 3600.0;
  assert_near_relative((double)up.band[1], 3.631e-11 * pow(10.0, -0.4 * 21.9) / (arc_second * arc_second), 0.02);
  assert_true(up.band[0] > up.band[1] && up.band[2] < up.band[1]);
  /* van Rhijn: 1/√(1 − (R sin z/(R + h))²); the shell's 10 km make it less than 1 % other at 80°. */
  for (int zenith = 20; zenith <= 80; zenith += 20) {
    const double z = zenith * NP_DEGREE, s = sin(z) * radius / (radius + 90e3);
    const np_vec3 direction = np_vec3_make((float)sin(z), 0, (float)cos(z));
    const np_spectrum at = np_airglow_radiance(&glow, np_dvec3_make(0, 0, 0), direction);
    assert_near_relative((double)at.band[1] / (double)up.band[1], 1.0 / sqrt(1.0 - s * s), 0.01);
  }
  /* Seen from above, the layer lies below: nothing upwards, twice the layer across the limb, at most its own chord. */
  const np_dvec3 orbit = np_dvec3_make(0, 0, 400e3);
  assert_near((double)np_airglow_radiance(&glow, orbit, np_vec3_make(0, 0, 1)).band[1], 0.0, 0.0);
  const double grazing = acos((radius + 60e3) / (radius + 400e3));
  const np_spectrum limb =
      np_airglow_radiance(&glow, orbit, np_vec3_make((float)cos(grazing), 0, (float)-sin(grazing)));
  assert_true(limb.band[1] > 10.0f * up.band[1] && limb.band[1] < 100.0f * up.band[1]);
}

/* Stars are steady at a setting of 0; low ones twinkle more. */
static void twinkling_keeps_the_mean(void **state) {
  (void)state;
  assert_near((double)np_star_twinkle(0.0f, 0.3f, 2.0f), 1.0, 0.0);
  double sum = 0.0, weight = 0.0;
  for (int i = -4000; i <= 4000; i++) { /* the normal density, by its own integral */
    const double g = i / 500.0, density = exp(-0.5 * g * g);
    sum += density * (double)np_star_twinkle(0.1f, 0.3f, (float)g);
    weight += density;
  }
  assert_near(sum / weight, 1.0, 1e-4); /* float exponentials */
  assert_true(np_star_twinkle(0.1f, 0.2f, 1.0f) > np_star_twinkle(0.1f, 1.0f, 1.0f));
}

/* ---- Catalogues ---- */

static void sirius_leads_the_bright_stars(void **state) {
  (void)state;
  const np_star_catalogue bright = np_star_catalogue_bright();
  assert_true(bright.count >= 50);
  const np_star *sirius = &bright.stars[0];
  assert_near((double)sirius->ascension_deg, 101.287, 0.001);
  assert_near((double)sirius->declination_deg, -16.716, 0.001);
  assert_near((double)sirius->v_magnitude, -1.46, 1e-6);
  for (size_t i = 0; i < bright.count; i++) {
    const np_star *star = &bright.stars[i];
    assert_true(star->ascension_deg >= 0 && star->ascension_deg < 360 && fabsf(star->declination_deg) <= 90);
    assert_true(star->v_magnitude >= -1.46f && star->v_magnitude < 3.5f && fabsf(star->b_minus_v - 0.8f) < 1.2f);
    assert_near(np_dvec3_length(np_star_direction(star)), 1.0, 1e-9);
  }
}

static char *write_text(const test_fixture *f, const char *text) {
  char *path = test_path(f->folder, "stars.csv");
  test_file_write_text(path, text);
  return path;
}

static void catalogues_are_read_by_column(void **state) {
  test_fixture *f = *state;
  char *path = write_text(f, "# from VizieR\nHIP,Vmag,RAICRS,DEICRS,B-V\n32349,-1.44,101.28854,-16.71314,0.009\n"
                             "55203,,169.5,31.5,\n99,7.5,10,20,\n");
  np_star_catalogue all, few;
  assert_int_equal(np_star_catalogue_load(f->context, path, 40.0, &all), NEPH_OK);
  assert_int_equal(all.count, 2); /* the one without a magnitude is none */
  assert_near((double)all.stars[0].declination_deg, -16.71314, 1e-5);
  assert_near((double)all.stars[1].b_minus_v, 0.65, 1e-6);
  assert_int_equal(np_star_catalogue_load(f->context, path, 6.0, &few), NEPH_OK);
  assert_int_equal(few.count, 1);
  np_star_catalogue_clear(&all);
  np_star_catalogue_clear(&few);
  free(path);
}

static void assert_refused(test_fixture *f, const char *text, const char *what, const char *allowed) {
  char *path = write_text(f, text);
  np_star_catalogue catalogue;
  assert_int_equal(np_star_catalogue_load(f->context, path, 40.0, &catalogue), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "stars.csv", what, allowed);
  assert_null(catalogue.stars);
  free(path);
}

static void wrong_catalogues_are_refused(void **state) {
  test_fixture *f = *state;
  assert_refused(f, "ra,dec_deg,v_mag\n1,2,3\n", "no column for the right ascension", "ra_deg");
  assert_refused(f, "ra_deg,dec,v_mag\n1,2,3\n", "no column for the declination", "dec_deg");
  assert_refused(f, "ra_deg,dec_deg,mag\n1,2,3\n", "no column for the V magnitude", "v_mag");
  assert_refused(f, "ra_deg,dec_deg,v_mag\n1,91,3\n", ":2", "91");
  assert_refused(f, "ra_deg,dec_deg,v_mag\n1,2,bright\n", ":2", "bright");
}

/* ---- Maps ---- */

static char *write_map(const test_fixture *f, unsigned width, unsigned height, float value) {
  static const char *const names[] = {"Y"};
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, width, height, 1, names, &image), NEPH_OK);
  float *plane = neph_image_get_channel(image, "Y");
  for (unsigned i = 0; i < width * height; i++) plane[i] = (float)i;
  plane[0] = value;
  char *path = test_path(f->folder, "map.exr");
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  return path;
}

/* Longitude 0 in the middle; right of it on a globe is left of it in the sky. */
static void maps_are_looked_up_by_direction(void **state) {
  test_fixture *f = *state;
  char *path = write_map(f, 8, 4, 0.0f);
  np_sphere_map globe, sky;
  assert_int_equal(np_sphere_map_load(f->context, "moon.map", path, false, &globe), NEPH_OK);
  assert_int_equal(np_sphere_map_load(f->context, "stars.map", path, true, &sky), NEPH_OK);
  /* Between rows 1 and 2, columns 3 and 4. */
  assert_near((double)np_sphere_map_lookup(&globe, 1, 0, 0).band[0], 0.25 * (11 + 12 + 19 + 20), 1e-5);
  const double east = 22.5 * NP_DEGREE; /* the middle of column 4 */
  assert_near((double)np_sphere_map_lookup(&globe, (float)cos(east), (float)sin(east), 0).band[1], 16, 1e-4);
  assert_near((double)np_sphere_map_lookup(&sky, (float)cos(east), (float)sin(east), 0).band[1], 15, 1e-4);
  /* Across the seam, and at the poles, every direction has a value. */
  assert_near((double)np_sphere_map_lookup(&globe, -1, 0, 0).band[2], 0.25 * (8 + 15 + 16 + 23), 1e-4);
  assert_true(np_sphere_map_lookup(&globe, 0, 0, 1).band[0] <= 7.0f);
  assert_true(np_sphere_map_lookup(&globe, 0, 0, -1).band[0] >= 24.0f);
  np_sphere_map_clear(&globe);
  np_sphere_map_clear(&sky);
  free(path);
}

static void wrong_maps_are_refused(void **state) {
  test_fixture *f = *state;
  np_sphere_map map;
  char *path = write_map(f, 4, 4, 0.0f);
  assert_int_equal(np_sphere_map_load(f->context, "moon.map", path, false, &map), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "moon.map", "4 x 4", "twice as wide");
  free(path);
  path = write_map(f, 8, 4, -1.0f);
  assert_int_equal(np_sphere_map_load(f->context, "stars.map", path, true, &map), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "stars.map", "pixel (0, 0) is -1", "at least 0");
  assert_null(map.texels);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_star_has_its_magnitudes),
      cmocka_unit_test(airglow_has_its_brightness_and_brightens_to_the_horizon),
      cmocka_unit_test(twinkling_keeps_the_mean),
      cmocka_unit_test(sirius_leads_the_bright_stars),
      TEST(catalogues_are_read_by_column),
      TEST(wrong_catalogues_are_refused),
      TEST(maps_are_looked_up_by_direction),
      TEST(wrong_maps_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
