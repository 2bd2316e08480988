/* SPDX-License-Identifier: Apache-2.0 */
/* Previews by the view of a camera: white balance, glare, tone. */
#include <nephos/exposure.h>

#include "test_support.h"

#include <stdlib.h>

#include "core/units.h"
#include "image/color_space.h"
#include "image/exposure.h"
#include "image/glare.h"
#include "image/preview.h"
#include "image/preview_camera.h"

static int set_up(void **state) { return test_set_up(state, 2, "picture.png"); }

/* ---- Pictures ---- */

enum { WIDTH = 321, HEIGHT = 181, COUNT = WIDTH * HEIGHT };
static const double fov_rad = 40.0 * NP_DEGREE;

static neph_image *create_grey(neph_context *context, float value) {
  static const char *const names[] = {"R", "G", "B"};
  neph_image *image;
  assert_int_equal(neph_image_create(context, WIDTH, HEIGHT, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < COUNT; i++) image->channels[c].values[i] = value;
  return image;
}

/* A perspective camera that looks along z. */
static void set_camera(neph_image *image) {
  float *m = image->header.world_to_ndc;
  image->header.has_camera = image->header.has_ndc = true;
  m[0] = m[5] = (float)(0.5 / tan(0.5 * fov_rad));
  m[8] = m[9] = 0.5f;
  m[10] = m[11] = 1.0f;
}

static void set_sun(neph_image *image, const char *x, const char *y, const char *elevation) {
  assert_int_equal(neph_image_set_attribute(image, NP_EXPOSURE_METER_X, x), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, NP_EXPOSURE_METER_Y, y), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, NP_EXPOSURE_SUN_ELEVATION, elevation), NEPH_OK);
}

static void set_pixel(neph_image *image, int i, float r, float g, float b) {
  image->channels[0].values[i] = r;
  image->channels[1].values[i] = g;
  image->channels[2].values[i] = b;
}

/* ---- Glare ---- */

/* Light of a picture behind a lens that scatters a share of it. */
static float *spread(const neph_image *image, double share) {
  np_preview_planes planes;
  float *out = calloc(COUNT, 3 * sizeof *out);
  assert_non_null(out);
  assert_true(np_preview_get_planes(image, NEPH_PIXEL_FLOAT, &planes));
  for (int c = 0; c < 3; c++) planes.factor[c] = 1.0f;
  assert_int_equal(np_glare_create(image, share, np_glare_get_pixel_rad(image), true, &planes), NEPH_OK);
  for (size_t i = 0; i < COUNT; i++) np_preview_get_pixel(&planes, i, out + 3 * i);
  np_glare_destroy(image, &planes);
  return out;
}

static double add_up(const float *rgb) {
  double sum = 0.0;
  for (int i = 0; i < COUNT; i++) sum += (double)rgb[3 * i + 1];
  return sum;
}

static void the_angle_of_a_pixel_is_the_camera_s(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_grey(f->context, 0.0f);
  assert_true(np_glare_get_pixel_rad(image) == 0.0);
  set_camera(image);
  const double expected = 2.0 * tan(0.5 * fov_rad) / WIDTH;
  assert_near_relative(np_glare_get_pixel_rad(image), expected, 1e-6);
  image->header.has_window = true; /* the right half of a picture */
  image->header.data_min[0] = WIDTH;
  image->header.display_max[0] = 2 * WIDTH - 1;
  assert_near_relative(np_glare_get_pixel_rad(image), 0.5 * expected, 1e-6);
  image->header.world_to_ndc[11] = 0.0f; /* parallel rays */
  assert_true(np_glare_get_pixel_rad(image) == 0.0);
  neph_image_destroy(image);
}

/* The light of a point in the middle, at the border and in the corner is all in the picture; a constant picture stays
 * as it is. */
static void glare_keeps_light(void **state) {
  test_fixture *f = *state;
  static const int places[] = {HEIGHT / 2 * WIDTH + WIDTH / 2, HEIGHT / 2 * WIDTH, 0, COUNT - 1, 77 * WIDTH + 31};
  for (size_t p = 0; p < sizeof places / sizeof *places; p++) {
    neph_image *image = create_grey(f->context, 0.0f);
    set_camera(image);
    set_pixel(image, places[p], 1e4f, 1e4f, 1e4f);
    float *rgb = spread(image, 0.06);
    assert_near_relative(add_up(rgb), 1e4, 1e-3);
    assert_true(rgb[3 * places[p] + 1] < 1e4f * 0.97f && rgb[3 * places[p] + 1] > 1e4f * 0.93f);
    free(rgb);
    neph_image_destroy(image);
  }
  neph_image *constant = create_grey(f->context, 0.25f);
  set_camera(constant);
  float *rgb = spread(constant, 0.5);
  for (int i = 0; i < 3 * COUNT; i++) assert_near((double)rgb[i], 0.25, 1e-6);
  free(rgb);
  neph_image_destroy(constant);
}

/* The mixture of Gaussians in glare.h, by fine steps: light in a pixel at `angle` from a point of light 1. */
static double get_psf(double angle, double pixel) {
  double sum = 0.0, all = 0.0;
  for (double log_sigma = -18.0; log_sigma < 4.0; log_sigma += 0.01) {
    const double s = exp(log_sigma), below = 0.03 * NP_DEGREE / s, above = s / (20.0 * NP_DEGREE);
    const double weight = pow(s, -0.2) * exp(-0.5 * (below * below + above * above));
    sum += weight * exp(-0.5 * angle * angle / (s * s)) / (2.0 * NP_PI * s * s) * pixel * pixel;
    all += weight;
  }
  return sum / all;
}

/* Light at a pixel of a point in the middle, and of its images in the borders. */
static double get_mirrored_psf(int x, int y, double pixel) {
  double sum = 0.0;
  for (int v = -1; v <= 1; v++)
    for (int u = -1; u <= 1; u++)
      sum += get_psf(pixel * hypot(x - WIDTH / 2 - u * WIDTH, y - HEIGHT / 2 - v * HEIGHT), pixel);
  return sum;
}

/* Rings from 4 to 60 pixels about a point have the mixture's light within 5 %, and that falls as the power of −2.2. */
static void glare_falls_by_its_power(void **state) {
  test_fixture *f = *state;
  enum { X = WIDTH / 2, Y = HEIGHT / 2 };
  neph_image *image = create_grey(f->context, 0.0f);
  set_camera(image);
  set_pixel(image, Y * WIDTH + X, 1.0f, 1.0f, 1.0f);
  const double pixel = np_glare_get_pixel_rad(image);
  float *rgb = spread(image, 0.1);
  for (int ring = 4; ring <= 60; ring += 8) {
    double found = 0.0, expected = 0.0;
    for (int y = 0; y < HEIGHT; y++)
      for (int x = 0; x < WIDTH; x++) {
        const double away = hypot(x - X, y - Y);
        if (fabs(away - ring) > 0.5) continue;
        found += (double)rgb[3 * (y * WIDTH + x)];
        expected += 0.1 * get_mirrored_psf(x, y, pixel);
      }
    assert_near_relative(found, expected, 0.05);
  }
  const double slope = log(get_psf(30.0 * pixel, pixel) / get_psf(3.0 * pixel, pixel)) / log(10.0);
  assert_near(slope, -2.2, 0.05);
  free(rgb);
  neph_image_destroy(image);
}

/* Neither NaN nor infinite nor negative pixels change their neighbours. */
static void odd_pixels_do_not_spread(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_grey(f->context, 0.25f), *black = create_grey(f->context, 0.25f);
  static const int odd[] = {1000, 20000, 30000, 40000};
  set_camera(image);
  set_camera(black);
  set_pixel(image, odd[0], NAN, 0.1f, 0.1f);
  set_pixel(image, odd[1], 0.1f, HUGE_VALF, 0.1f);
  set_pixel(image, odd[2], -HUGE_VALF, 0.1f, NAN);
  set_pixel(image, odd[3], -1e30f, -1.0f, -5.0f);
  for (int i = 0; i < 4; i++) set_pixel(black, odd[i], 0.0f, 0.0f, 0.0f);
  float *of_odd = spread(image, 0.06), *of_black = spread(black, 0.06);
  for (int i = 0; i < COUNT; i++)
    if (i != odd[0] && i != odd[1] && i != odd[2] && i != odd[3])
      assert_memory_equal(of_odd + 3 * i, of_black + 3 * i, 3 * sizeof(float));
  uint8_t *pixels = calloc(COUNT, 4);
  assert_int_equal(neph_image_develop(image, NULL, 0, 0, WIDTH, HEIGHT, pixels, 4 * WIDTH), NEPH_OK);
  static const uint8_t shown[2][3] = {{255, 0, 255}, {255, 255, 255}};
  for (int i = 0; i < 2; i++) assert_memory_equal(pixels + 4 * odd[i], shown[i], 3);
  free(pixels);
  free(of_black);
  free(of_odd);
  neph_image_destroy(black);
  neph_image_destroy(image);
}

/* A picture of dim ramps, and a sun. */
static neph_image *create_scene(neph_context *context) {
  neph_image *image = create_grey(context, 0.0f);
  for (int i = 0; i < COUNT; i++) {
    const float x = (float)(i % WIDTH) / WIDTH, y = (float)(i / WIDTH) / HEIGHT;
    set_pixel(image, i, 0.2f * x, 0.3f * y, 0.5f - 0.4f * x * y);
  }
  set_camera(image);
  set_pixel(image, 40 * WIDTH + 60, 3e4f, 2e4f, 1e4f);
  return image;
}

static uint8_t *develop(const neph_image *image, const neph_preview_desc *desc) {
  uint8_t *pixels = calloc(COUNT, 4);
  assert_non_null(pixels);
  assert_int_equal(neph_image_develop(image, desc, 0, 0, WIDTH, HEIGHT, pixels, 4 * WIDTH), NEPH_OK);
  return pixels;
}

/* A glare of 0 gives the bits of a picture without a camera, and 0.06 others. */
static void no_glare_is_exactly_none(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_scene(f->context), *flat = create_scene(f->context);
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  flat->header.has_ndc = false;
  uint8_t *with = develop(image, &desc), *without_camera = develop(flat, &desc);
  desc.glare = 0.0;
  uint8_t *without = develop(image, &desc);
  assert_memory_equal(without, without_camera, COUNT * 4);
  assert_memory_not_equal(with, without, COUNT * 4);
  free(without);
  free(without_camera);
  free(with);
  neph_image_destroy(flat);
  neph_image_destroy(image);
}

/* Pixels in memory, which one thread develops, are those of the file, by two threads, to the dither; and a rectangle is
 * that of the whole picture. */
static void threads_and_rectangles_do_not_matter(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_scene(f->context), *loaded;
  uint8_t *pixels = develop(image, NULL), part[4 * 40 * 30];
  assert_int_equal(neph_image_save_png(image, f->path, NULL), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, f->path, &loaded), NEPH_OK);
  for (int i = 0; i < COUNT; i++)
    for (int c = 0; c < 3; c++)
      assert_near((double)pixels[4 * i + c], 255.0 * (double)loaded->channels[c].values[i], 1.001);
  assert_int_equal(neph_image_develop(image, NULL, 50, 30, 90, 60, part, 160), NEPH_OK);
  for (int y = 0; y < 30; y++) assert_memory_equal(part + 160 * y, pixels + 4 * ((y + 30) * WIDTH + 50), 160);
  np_preview_planes serial, parallel;
  assert_true(np_preview_get_planes(image, NEPH_PIXEL_FLOAT, &serial));
  for (int c = 0; c < 3; c++) serial.factor[c] = 1.0f;
  parallel = serial;
  assert_int_equal(np_glare_create(image, 0.06, 1e-3, false, &serial), NEPH_OK);
  assert_int_equal(np_glare_create(image, 0.06, 1e-3, true, &parallel), NEPH_OK);
  assert_memory_equal(serial.veil, parallel.veil, COUNT * 3 * sizeof(float));
  np_glare_destroy(image, &parallel);
  np_glare_destroy(image, &serial);
  free(pixels);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* ---- White balance ---- */

static void balance_goes_by_the_sun(void **state) {
  (void)state;
  static const double shares[][2] = {{-90, 0}, {5, 0}, {10, 0.5}, {15, 1}, {90, 1}};
  for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
    assert_near(np_preview_get_balance_share(shares[i][0], -90.0), shares[i][1], 1e-12);
}

/* Sunsets and twilight keep their colours, with and without a moon. */
static void balance_goes_by_the_moon_at_night(void **state) {
  (void)state;
  static const struct {
    double sun, moon, share;
  } rows[] = {{-40, 5, 0},      {-40, 10, 0.5}, {-40, 60, 1}, {-18, 60, 1},
              {-13.5, 60, 0.5}, {-9, 60, 0},    {4, 60, 0},   {60, 60, 1}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    assert_near(np_preview_get_balance_share(rows[i].sun, rows[i].moon), rows[i].share, 1e-12);
}

/* A grey card in daylight of 5503 K (CIE D55: x 0.3324, y 0.3475): R, G and B of Rec.709 for Y 0.18. */
static void show_card(test_fixture *f, const char *elevation, const char *moon_elevation, uint8_t out[3]) {
  static const double x = 0.33243, y = 0.34744;
  const double xyz[3] = {0.18 * x / y, 0.18, 0.18 * (1.0 - x - y) / y};
  const np_color_matrix m = np_color_space_from_xyz(NP_COLOR_REC709);
  double rgb[3];
  for (int r = 0; r < 3; r++) rgb[r] = m.at[r][0] * xyz[0] + m.at[r][1] * xyz[1] + m.at[r][2] * xyz[2];
  neph_image *image = create_grey(f->context, 0.0f);
  for (int i = 0; i < COUNT; i++) set_pixel(image, i, (float)rgb[0], (float)rgb[1], (float)rgb[2]);
  if (elevation) set_sun(image, "0.33243", "0.34744", elevation);
  if (moon_elevation)
    assert_int_equal(neph_image_set_attribute(image, "nephos:moonElevation", moon_elevation), NEPH_OK);
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure = NEPH_EXPOSURE_FIXED;
  uint8_t *pixels = develop(image, &desc);
  memcpy(out, pixels, 3);
  free(pixels);
  neph_image_destroy(image);
}

/* The card is neutral at noon, and as warm below 5° as in a picture that states no sun; at 10° it is between. */
static void a_grey_card_is_neutral_at_noon(void **state) {
  test_fixture *f = *state;
  uint8_t noon[3], between[3], low[3], unknown[3], moonlit[3];
  show_card(f, "60", NULL, noon);
  show_card(f, "10", NULL, between);
  show_card(f, "4.9", NULL, low);
  show_card(f, NULL, NULL, unknown);
  show_card(f, "-40", "60", moonlit);
  assert_true(noon[0] == noon[1] && noon[1] == noon[2]);
  assert_memory_equal(moonlit, noon, 3);
  assert_memory_equal(low, unknown, 3);
  assert_true(low[0] > low[2] + 12);
  assert_true(between[0] - between[2] > 4 && between[0] - between[2] < low[0] - low[2] - 4);
}

static void a_white_of_no_light_is_left_out(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_scene(f->context);
  uint8_t *plain = develop(image, NULL);
  set_sun(image, "0.9", "0.01", "50");
  uint8_t *bad = develop(image, NULL);
  assert_non_null(strstr(f->log.text, "no chromaticity of a white"));
  assert_memory_equal(bad, plain, COUNT * 4);
  free(bad);
  free(plain);
  neph_image_destroy(image);
}

/* ---- Tone ---- */

static double get_luminance(const float rgb[3]) {
  return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

/* Angle of a chromaticity about D65 in degrees; `out_purity` is its distance. */
static double get_hue(const float rgb[3], double *out_purity) {
  const double color[3] = {(double)rgb[0], (double)rgb[1], (double)rgb[2]};
  double xy[2];
  np_color_space_get_chromaticity(color, xy);
  const double x = xy[0] - 0.3127, y = xy[1] - 0.3290;
  *out_purity = hypot(x, y);
  return atan2(y, x) / NP_DEGREE;
}

/* Light of one chromaticity from sixteen stops below white to sixteen above gets brighter all the way, keeps its hue
 * within 2 degrees wherever it has one, and keeps the order of R, G and B. */
static void hues_stay_and_light_rises(void **state) {
  (void)state;
  const float hues[][3] = {{1, 1, 1},        {0.17f, 0.41f, 1}, {1, 0.6f, 0.3f},
                           {1, 0.2f, 0.05f}, {0.9f, 0.95f, 1},  {0, 0, 1}};
  for (size_t h = 0; h < sizeof hues / sizeof *hues; h++) {
    double before = 0.0, purity;
    const double hue = get_hue(hues[h], &purity);
    for (float stops = -16; stops < 16; stops += 0.0625f) {
      float exposed[3], display[3];
      for (int c = 0; c < 3; c++) exposed[c] = exp2f(stops) * hues[h][c];
      np_preview_map_camera(exposed, display);
      const double luminance = get_luminance(display), shown = get_hue(display, &purity);
      assert_true(luminance >= before * (1.0 - 1e-6) && luminance <= 1.000001);
      if (h && purity > 0.003) assert_true(fabs(remainder(shown - hue, 360.0)) < 2.0);
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
          if (hues[h][c] > hues[h][d]) assert_true(display[c] >= display[d] - 1e-6f);
      before = luminance;
    }
  }
}

/* Grey of 0.22 is lifted by 0.45 stops, black of 0.001 by less than a fiftieth of a stop, and white keeps its drawing:
 * 0.92, the exposure of highlights, comes to a component of 244 to 248. */
static void midtones_are_lifted(void **state) {
  (void)state;
  const float grey[3] = {0.22f, 0.22f, 0.22f}, black[3] = {0.001f, 0.001f, 0.001f}, white[3] = {0.92f, 0.92f, 0.92f};
  float display[3];
  np_preview_map_camera(grey, display);
  assert_near(log2((double)display[1] / 0.22), 0.45, 1e-3);
  np_preview_map_camera(black, display);
  assert_near(log2((double)display[1] / 0.001), 0.0, 0.02);
  np_preview_map_camera(white, display);
  const double component = 255.0 * (1.055 * pow((double)display[1], 1.0 / 2.4) - 0.055);
  assert_true(component > 244.0 && component < 248.0);
}

/* Light beyond every sensor is white, and light of no value black. */
static void extremes_have_a_tone(void **state) {
  (void)state;
  const float bright[3] = {3e38f, 2.9e38f, 3e38f}, none[3] = {-3e38f, -HUGE_VALF, 0.0f};
  float display[3];
  np_preview_map_camera(bright, display);
  for (int c = 0; c < 3; c++) assert_near((double)display[c], 1.0, 1e-6);
  np_preview_map_camera(none, display);
  for (int c = 0; c < 3; c++) assert_true(display[c] == 0.0f);
}

/* Neighbours of a ramp of 4096 steps never differ by more than its slope allows: the curve has no steps. */
static void ramps_do_not_band(void **state) {
  (void)state;
  float before = 0.0f;
  for (int i = 1; i < 4096; i++) {
    const float x = (float)i / 4096, exposed[3] = {x, x, x};
    float display[3];
    np_preview_map_camera(exposed, display);
    const float step = display[1] - before;
    assert_true(step > 0.0f && step < 1.6f / 4096);
    before = display[1];
  }
}

static void bad_glare_is_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_scene(f->context);
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  static const double bad[] = {-0.01, 0.51, (double)NAN};
  for (int i = 0; i < 3; i++) {
    desc.glare = bad[i];
    assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  }
  assert_non_null(strstr(f->log.text, "preview glare is -0.01, must be a share in [0, 0.5]"));
  neph_image_destroy(image);
}

#define CAMERA_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      CAMERA_TEST(the_angle_of_a_pixel_is_the_camera_s),
      CAMERA_TEST(glare_keeps_light),
      CAMERA_TEST(glare_falls_by_its_power),
      CAMERA_TEST(odd_pixels_do_not_spread),
      CAMERA_TEST(no_glare_is_exactly_none),
      CAMERA_TEST(threads_and_rectangles_do_not_matter),
      CAMERA_TEST(balance_goes_by_the_sun),
      CAMERA_TEST(balance_goes_by_the_moon_at_night),
      CAMERA_TEST(a_grey_card_is_neutral_at_noon),
      CAMERA_TEST(a_white_of_no_light_is_left_out),
      CAMERA_TEST(hues_stay_and_light_rises),
      CAMERA_TEST(midtones_are_lifted),
      CAMERA_TEST(ramps_do_not_band),
      CAMERA_TEST(extremes_have_a_tone),
      CAMERA_TEST(bad_glare_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
