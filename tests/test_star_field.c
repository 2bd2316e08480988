/* SPDX-License-Identifier: Apache-2.0 */
/* Stars in pictures: one flux at any resolution, dimmed by air, turned with their map. */
#include "test_nights.h"

#include "atmosphere/magnitudes.h"

static char *write_star(const test_fixture *f, double declination_deg) {
  char *path = test_path(f->folder, "one.csv");
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  assert_true(fprintf(file, "ra_deg,dec_deg,v_mag,b_v\n180,%g,1.25,0.4\n", declination_deg) > 0);
  assert_int_equal(fclose(file), 0);
  return path;
}

/* Radiance times solid angle over a picture of a pinhole, green. */
static double sum_flux(neph_image *image, double fov_rad) {
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  const float *green = neph_image_get_channel(image, "G");
  const double edge = 2.0 * tan(0.5 * fov_rad) / width;
  double sum = 0.0;
  for (unsigned y = 0; y < height; y++)
    for (unsigned x = 0; x < width; x++) {
      const double u = edge * (x + 0.5 - 0.5 * width), v = edge * (y + 0.5 - 0.5 * height);
      sum += (double)green[(size_t)y * width + x] * edge * edge / pow(1.0 + u * u + v * v, 1.5);
    }
  return sum;
}

/* Renders a star on the meridian from a place on the equator, without air; the star is off the centre. */
static neph_image *render_star(test_fixture *f, const char *path, unsigned width, const char *more) {
  char text[1024];
  snprintf(text, sizeof text,
           "place: {latitude: 0 deg, longitude: 0 deg}\natmosphere: none\nsun: {irradiance: 0}\n"
           "camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 0.9 m, 11 m], fov: 40 deg, resolution: [%u, %u]}\n"
           "stars: {catalogue: \"%s\", sidereal_time: 184 deg%s}\nrender: {samples: 1}",
           width, width * 3 / 4, path, more);
  return render(f, text);
}

/* The tent's weights add up to 1; floats keep 1e-5 of it. 1e-3 leaves room for nothing but those. */
static void a_star_has_one_flux_at_every_resolution(void **state) {
  test_fixture *f = *state;
  char *path = write_star(f, 40.0);
  const np_spectrum expected = np_star_irradiance(1.25, 0.4, bands_nm);
  static const unsigned widths[] = {37, 160, 1000};
  for (int i = 0; i < 3; i++) {
    neph_image *image = render_star(f, path, widths[i], "");
    assert_near_relative(sum_flux(image, 40.0 * NP_DEGREE), (double)expected.band[1], 2e-5);
    neph_image_destroy(image);
  }
  free(path);
}

static void a_star_keeps_its_flux_in_latitude_and_longitude(void **state) {
  test_fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    char *path = write_star(f, i ? 89.9 : 40.0); /* the second in the rows about the pole, which the place puts up */
    char text[512];
    snprintf(text, sizeof text,
             "place: {latitude: 89 deg, longitude: 0 deg}\natmosphere: none\nsun: {irradiance: 0}\n"
             "stars: {catalogue: \"%s\", sidereal_time: 100 deg}",
             path);
    neph_image *image = paint_sky(f, text, 128);
    const float *green = neph_image_get_channel(image, "G");
    double sum = 0.0;
    for (unsigned p = 0; p < 128 * 64; p++) {
      const double top = NP_PI * (p / 128) / 64.0, bottom = NP_PI * (p / 128 + 1) / 64.0;
      sum += (double)green[p] * (cos(top) - cos(bottom)) * 2.0 * NP_PI / 128.0;
    }
    assert_near_relative(sum, (double)np_star_irradiance(1.25, 0.4, bands_nm).band[1], 2e-5);
    neph_image_destroy(image);
    free(path);
  }
}

static unsigned search_brightest(neph_image *image) {
  const float *green = neph_image_get_channel(image, "G");
  unsigned best = 0;
  for (unsigned p = 0; p < count_pixels(image); p++)
    if (green[p] > green[best]) best = p;
  return best;
}

/* Right ascension 0 in the middle of the map, growing to the left: a texel shines where a star of its place stands. */
static void the_map_is_turned_like_the_stars(void **state) {
  test_fixture *f = *state;
  enum { WIDTH = 64, X = 20, Y = 10 };
  static const char *const names[] = {"Y"};
  neph_image *map;
  assert_int_equal(neph_image_create(f->context, WIDTH, WIDTH / 2, 1, names, &map), NEPH_OK);
  neph_image_get_channel(map, "Y")[Y * WIDTH + X] = 1.0f;
  char *map_path = test_path(f->folder, "map.exr"), *star_path = test_path(f->folder, "star.csv"), text[1024];
  assert_int_equal(neph_image_save_exr(map, map_path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(map);
  FILE *file = fopen(star_path, "w");
  assert_non_null(file);
  assert_true(fprintf(file, "ra_deg,dec_deg,v_mag\n%g,%g,1\n", 360.0 * (0.5 - (X + 0.5) / WIDTH),
                      180.0 * (0.5 - (Y + 0.5) / (WIDTH / 2))) > 0);
  assert_int_equal(fclose(file), 0);
  unsigned at[2];
  for (int i = 0; i < 2; i++) { /* the star alone; the map so bright that the star is nothing to it */
    snprintf(text, sizeof text,
             "place: {latitude: 35 deg, longitude: 0 deg}\natmosphere: none\nsun: {irradiance: 0}\n"
             "stars: {catalogue: \"%s\", sidereal_time: 40 deg%s%s%s}",
             star_path, i ? ", map: \"" : "", i ? map_path : "", i ? "\"" : "");
    neph_image *image = paint_sky(f, text, 256);
    at[i] = search_brightest(image);
    neph_image_destroy(image);
  }
  /* A texel is four pixels wide. */
  assert_true(abs((int)(at[0] % 256) - (int)(at[1] % 256)) <= 3 && abs((int)(at[0] / 256) - (int)(at[1] / 256)) <= 3);
  free(map_path);
  free(star_path);
}

static void stars_twinkle_only_when_asked(void **state) {
  test_fixture *f = *state;
  char *path = write_star(f, 40.0);
  neph_image *steady = render_star(f, path, 64, ""), *twinkling = render_star(f, path, 64, ", twinkling: 0.5");
  const double expected = (double)np_star_irradiance(1.25, 0.4, bands_nm).band[1];
  assert_near_relative(sum_flux(steady, 40.0 * NP_DEGREE), expected, 2e-5);
  assert_true(fabs(sum_flux(twinkling, 40.0 * NP_DEGREE) / expected - 1.0) > 0.01);
  neph_image_destroy(steady);
  neph_image_destroy(twinkling);
  free(path);
}

/* Through the air of the zenith a third of the green light of a low star is left; below the horizon nothing. */
static void air_dims_stars_towards_the_horizon(void **state) {
  test_fixture *f = *state;
  double flux[3];
  static const double declinations[3] = {90.0, 2.0, -2.0};
  for (int i = 0; i < 3; i++) {
    char *path = write_star(f, declinations[i]), text[512];
    snprintf(text, sizeof text,
             "place: {latitude: 90 deg, longitude: 0 deg}\nsun: {elevation: -40 deg}\n"
             "camera: {position: [0 m, 0 m, 0 m], look_at: [0 m, 1 m, 0 m]}\n"
             "stars: {catalogue: \"%s\", sidereal_time: 10 deg}",
             path);
    neph_image *image = paint_sky(f, text, 128);
    const float *green = neph_image_get_channel(image, "G");
    flux[i] = 0.0;
    for (unsigned p = 0; p < 128 * 64; p++)
      flux[i] += (double)green[p] * sin(NP_PI * (p / 128 + 0.5) / 64.0) * (NP_PI / 64.0) * (NP_PI / 64.0);
    neph_image_destroy(image);
    free(path);
  }
  const double outside = (double)np_star_irradiance(1.25, 0.4, bands_nm).band[1];
  assert_true(flux[0] > 0.8 * outside && flux[0] < 0.95 * outside);
  assert_true(flux[1] > 0.03 * outside && flux[1] < 0.4 * outside);
  assert_near(flux[2], 0.0, 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_star_has_one_flux_at_every_resolution), TEST(a_star_keeps_its_flux_in_latitude_and_longitude),
      TEST(the_map_is_turned_like_the_stars),        TEST(stars_twinkle_only_when_asked),
      TEST(air_dims_stars_towards_the_horizon),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
