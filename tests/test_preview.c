/* SPDX-License-Identifier: Apache-2.0 */
/* Previews: pictures as they are shown, in PNG files. */
#include "test_support.h"

#include <stdlib.h>

#include "image/color_space.h"
#include "image/exposure.h"
#include "image/preview.h"

static int set_up(void **state) { return test_set_up(state, 2, "picture.png"); }

/* ---- Pictures ---- */

enum { SIDE = 64 };

static neph_image *create_colour(neph_context *context, float r, float g, float b) {
  static const char *const names[] = {"R", "G", "B"};
  const float values[] = {r, g, b};
  neph_image *image;
  assert_int_equal(neph_image_create(context, SIDE, SIDE, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < SIDE * SIDE; i++) image->channels[c].values[i] = values[c];
  return image;
}

static void set_pixel(neph_image *image, int i, float r, float g, float b) {
  image->channels[0].values[i] = r;
  image->channels[1].values[i] = g;
  image->channels[2].values[i] = b;
}

static neph_preview_desc make_plain_desc(void) {
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure = NEPH_EXPOSURE_FIXED;
  desc.view = NEPH_VIEW_FILMIC;
  return desc;
}

static neph_image *save_and_load(test_fixture *f, const neph_image *image, const neph_preview_desc *desc) {
  neph_image *loaded;
  assert_int_equal(neph_image_save_png(image, f->path, desc), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, f->path, &loaded), NEPH_OK);
  return loaded;
}

static double average(const neph_image *image, unsigned channel) {
  double sum = 0;
  for (unsigned i = 0; i < image->width * image->height; i++) sum += (double)image->channels[channel].values[i];
  return sum / (image->width * image->height);
}

static double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

/* The mean of 4096 dithered pixels: one step of 1/255 has a standard deviation of 0.5 at most, so the mean is known to
 * 0.5/255/64 = 3e-5; five of them. */
static const double dithered_mean_tolerance = 1.5e-4;

static void middle_grey_shows_as_the_curve_says(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_plain_desc();
  neph_image *image = create_colour(f->context, 0.18f, 0.18f, 0.18f), *loaded = save_and_load(f, image, &desc);
  for (unsigned c = 0; c < 3; c++) assert_near(average(loaded, c), encode_srgb(0.18), dithered_mean_tolerance);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* Greys stay grey at every brightness, whatever the white is. */
static void white_shows_as_neutral(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_plain_desc();
  const double sun[3] = {1.474, 1.8504, 1.91198};
  memcpy(desc.white, sun, sizeof sun);
  for (int stops = -6; stops <= 6; stops++) {
    neph_image *image = create_colour(f->context, (float)sun[0], (float)sun[1], (float)sun[2]);
    desc.exposure_ev = stops;
    neph_image *loaded = save_and_load(f, image, &desc);
    for (unsigned c = 1; c < 3; c++) assert_near(average(loaded, c), average(loaded, 0), 2 * dithered_mean_tolerance);
    neph_image_destroy(loaded);
    neph_image_destroy(image);
  }
}

/* One colour, said in ACEScg's primaries and in Rec.709's, shows the same; half a step of 1/255 in one of the means is
 * what the rounding of its components comes to. */
static void primaries_of_the_header_are_honoured(void **state) {
  test_fixture *f = *state;
  const neph_preview_desc desc = make_plain_desc();
  neph_image *plain = create_colour(f->context, 0.30f, 0.18f, 0.06f);
  /* AP1 from Rec.709 by Bradford: 0.6131 0.3395 0.0474 / 0.0702 0.9164 0.0134 / 0.0206 0.1096 0.8698 */
  neph_image *wide = create_colour(f->context, 0.24789f, 0.18681f, 0.07810f);
  memcpy(wide->header.chromaticities, np_color_space_get_chromaticities(NP_COLOR_ACESCG),
         sizeof wide->header.chromaticities);
  neph_image *unsaid = save_and_load(f, wide, &desc);
  wide->header.has_chromaticities = true;
  neph_image *expected = save_and_load(f, plain, &desc), *shown = save_and_load(f, wide, &desc);
  for (unsigned c = 0; c < 3; c++) assert_near(average(shown, c), average(expected, c), 5e-4);
  assert_true(fabs(average(unsaid, 0) - average(expected, 0)) > 0.02);
  neph_image_destroy(unsaid);
  neph_image_destroy(shown);
  neph_image_destroy(expected);
  neph_image_destroy(wide);
  neph_image_destroy(plain);
}

/* More light is never darker in any channel, and order of channels never turns over: at every stop from black to burnt,
 * for the hues that matter. */
static void tones_rise_and_keep_their_order(void **state) {
  (void)state;
  const float hues[][3] = {{1, 1, 1}, {0.17f, 0.41f, 1}, {1, 0.6f, 0.3f}, {1, 0.2f, 0.05f}, {0.9f, 0.95f, 1}};
  for (size_t h = 0; h < sizeof hues / sizeof *hues; h++) {
    float before[3] = {0, 0, 0};
    for (float stops = -16; stops < 16; stops += 0.0625f) {
      float exposed[3], display[3];
      for (int c = 0; c < 3; c++) exposed[c] = exp2f(stops) * hues[h][c];
      np_preview_map_tone(exposed, display);
      for (int c = 0; c < 3; c++) {
        assert_true(display[c] >= before[c] - 1e-6f && display[c] <= 1.0f); /* equal to rounding at the top */
        for (int d = 0; d < 3; d++)
          if (hues[h][c] > hues[h][d]) assert_true(display[c] >= display[d] - 1e-6f);
        before[c] = display[c];
      }
    }
  }
}

static void negative_infinite_and_nan_pixels_are_safe(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_plain_desc();
  neph_image *image = create_colour(f->context, 0.2f, 0.2f, 0.2f);
  set_pixel(image, 0, -1, -INFINITY, -1e30f);
  set_pixel(image, 1, INFINITY, 0.2f, 0.2f);
  set_pixel(image, 2, 0.2f, NAN, INFINITY);
  set_pixel(image, 3, 3e38f, 3e38f, 3e38f);
  neph_image *loaded = save_and_load(f, image, &desc);
  const float expected[4][3] = {{0, 0, 0}, {1, 1, 1}, {1, 0, 1}, {1, 1, 1}};
  for (int i = 0; i < 4; i++)
    for (int c = 0; c < 3; c++) assert_true(loaded->channels[c].values[i] == expected[i][c]);
  assert_non_null(strstr(f->log.text, "1 pixels are NaN"));
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* A ramp over ten steps of 255 in 64 pixels: without dither it would be flat bands; with it, block means follow the
 * ramp to the noise of 64 pixels, 0.5/8 of a step; five of them. */
static void gradients_do_not_band(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_plain_desc();
  neph_image *image = create_colour(f->context, 0, 0, 0);
  for (int i = 0; i < SIDE * SIDE; i++) {
    float value = 0.18f + 0.02f * (float)(i % SIDE) / SIDE;
    set_pixel(image, i, value, value, value);
  }
  neph_image *loaded = save_and_load(f, image, &desc);
  for (int x = 0; x < SIDE; x++) {
    const float exposed[3] = {image->channels[0].values[x], image->channels[0].values[x], image->channels[0].values[x]};
    float display[3];
    double mean = 0;
    np_preview_map_tone(exposed, display);
    for (int y = 0; y < SIDE; y++) mean += (double)loaded->channels[1].values[y * SIDE + x] / SIDE;
    assert_near(mean, encode_srgb((double)display[1]), 5 * 0.5 / 8 / 255);
  }
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

static const neph_preview_desc plain = NEPH_PREVIEW_DESC_DEFAULT;

/* Values that no half holds, of which dither makes the most. */
static neph_image *create_ramp(neph_context *context) {
  neph_image *image = create_colour(context, 0, 0, 0);
  for (int i = 0; i < SIDE * SIDE; i++) set_pixel(image, i, 0.1f + 1e-5f * (float)i, 0.2f, 0.3f + 3e-5f * (float)i);
  return image;
}

/* Rows from the middle on are a tile's: it shows them as the whole does. */
static void a_tile_shows_what_the_whole_does(void **state) {
  enum { HALF = SIDE / 2 * SIDE };
  test_fixture *f = *state;
  const neph_preview_desc desc = make_plain_desc();
  neph_image *image = create_ramp(f->context), *whole = save_and_load(f, image, &desc);
  for (int i = 0; i < HALF; i++)
    for (int c = 0; c < 3; c++) image->channels[c].values[i] = image->channels[c].values[i + HALF];
  image->header.has_window = true;
  image->header.data_min[1] = SIDE / 2;
  neph_image *tile = save_and_load(f, image, &desc);
  for (int c = 0; c < 3; c++)
    assert_memory_equal(tile->channels[c].values, whole->channels[c].values + HALF, HALF * sizeof(float));
  neph_image_destroy(tile);
  neph_image_destroy(whole);
  neph_image_destroy(image);
}

/* A preview of halves equals that of the file; one of floats does not, and a picture too bright for halves is shown in
 * floats, like its file. */
static void halves_show_what_their_file_does(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = plain;
  neph_image *image = create_ramp(f->context), *kept;
  neph_image *of_floats = save_and_load(f, image, &desc);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_HALF), NEPH_OK);
  assert_int_equal(neph_image_load_exr(f->context, f->path, &kept), NEPH_OK);
  neph_image *of_file = save_and_load(f, kept, &desc);
  desc.pixel_type = NEPH_PIXEL_HALF;
  neph_image *of_halves = save_and_load(f, image, &desc);
  const size_t bytes = SIDE * SIDE * sizeof(float);
  for (int c = 0; c < 3; c++) assert_memory_equal(of_halves->channels[c].values, of_file->channels[c].values, bytes);
  assert_memory_not_equal(of_halves->channels[2].values, of_floats->channels[2].values, bytes);
  set_pixel(image, 0, 1e5f, 1e5f, 1e5f);
  neph_image *bright = save_and_load(f, image, &desc);
  desc.pixel_type = NEPH_PIXEL_FLOAT;
  neph_image *bright_floats = save_and_load(f, image, &desc);
  for (int c = 0; c < 3; c++) assert_memory_equal(bright->channels[c].values, bright_floats->channels[c].values, bytes);
  neph_image *const all[] = {image, kept, of_floats, of_file, of_halves, bright, bright_floats};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) neph_image_destroy(all[i]);
}

static void previews_repeat(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0.1f, 0.3f, 0.7f);
  neph_image *first = save_and_load(f, image, NULL), *second = save_and_load(f, image, NULL);
  for (int c = 0; c < 3; c++)
    assert_memory_equal(first->channels[c].values, second->channels[c].values, SIDE * SIDE * sizeof(float));
  neph_image_destroy(second);
  neph_image_destroy(first);
  neph_image_destroy(image);
}

/* ---- Exposure ---- */

/* Histogram bins are 1/16 stop wide, so a result may lie half of one off: 2.2 %. */
static const double bin_tolerance = 0.022;

static void exposure_undoes_any_scale(void **state) {
  test_fixture *f = *state;
  neph_image *bright = create_colour(f->context, 0.1f, 0.2f, 0.4f),
             *dim = create_colour(f->context, 1e-7f, 2e-7f, 4e-7f);
  double of_bright = np_exposure_choose_by_picture(bright, &plain), of_dim = np_exposure_choose_by_picture(dim, &plain);
  assert_near_relative(of_dim / of_bright, 1e6, 2 * bin_tolerance);
  neph_image_destroy(dim);
  neph_image_destroy(bright);
}

/* Neither nine tenths of black, nor of almost black, nor a sun of 25 pixels in 4096, changes what a lit patch gets. */
static void black_borders_and_the_sun_do_not_turn_the_exposure(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0.3f, 0.3f, 0.3f);
  double expected = np_exposure_choose_by_picture(image, &plain);
  for (int i = 0; i < 25; i++) set_pixel(image, 100 + i, 3e4f, 3e4f, 3e4f);
  assert_near_relative(np_exposure_choose_by_picture(image, &plain), expected, 2 * bin_tolerance);
  neph_image *dark = create_colour(f->context, 0, 0, 0);
  for (int i = 0; i < SIDE * SIDE / 10; i++) set_pixel(dark, i, 0.3f, 0.3f, 0.3f);
  assert_near_relative(np_exposure_choose_by_picture(dark, &plain), expected, 2 * bin_tolerance);
  for (int i = SIDE * SIDE / 10; i < SIDE * SIDE; i++) set_pixel(dark, i, 1e-6f, 1e-6f, NAN);
  assert_near_relative(np_exposure_choose_by_picture(dark, &plain), expected, 2 * bin_tolerance);
  for (int i = SIDE * SIDE / 10; i < SIDE * SIDE; i++) set_pixel(dark, i, 1e-6f, 1e-6f, 1e-6f);
  assert_near_relative(np_exposure_choose_by_picture(dark, &plain), expected, 2 * bin_tolerance);
  neph_image_destroy(dark);
  neph_image_destroy(image);
}

/* A white cloud over a tenth of a picture keeps its drawing: it comes to 0.92, below the end of the shoulder, whatever
 * is around it, unless nearly all of that would be black: then the rest has 0.08 in the mean of logarithms. */
static void highlights_set_the_exposure(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0.2f, 0.2f, 0.2f);
  for (int i = 0; i < SIDE * SIDE / 10; i++) set_pixel(image, i, 1, 1, 1);
  assert_near_relative(np_exposure_choose_by_picture(image, &plain), 0.92, 2 * bin_tolerance);
  neph_image_destroy(image);
  image = create_colour(f->context, 0.01f, 0.01f, 0.01f);
  for (int i = 0; i < SIDE * SIDE / 50; i++) set_pixel(image, i, 1, 1, 1);
  const double rest = exp2((0.88 * log2(0.01) + 0.02 * log2(1.0)) / 0.9); /* without the darkest tenth */
  assert_near_relative(np_exposure_choose_by_picture(image, &plain), 0.08 / rest, 3 * bin_tolerance);
  neph_image_destroy(image);
}

/* The meter takes the light from the header: a white diffuser of noon shows as 0.8 whatever the picture is; one a
 * million times dimmer, by moonlight, stays some stops darker; and a picture without the attributes is refused. */
static void the_meter_keeps_night_dark(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure = NEPH_EXPOSURE_METER;
  neph_image *image = create_colour(f->context, 1, 1, 1);
  assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "no attribute nephos:meter");
  double factor[2];
  static const char *const luminances[] = {"30000", "0.03"};
  for (int i = 0; i < 2; i++) {
    assert_int_equal(neph_image_set_attribute(image, NP_EXPOSURE_METER, "0.5"), NEPH_OK);
    assert_int_equal(neph_image_set_attribute(image, NP_EXPOSURE_METER_LUMINANCE, luminances[i]), NEPH_OK);
    assert_int_equal(np_exposure_choose(image, &desc, &factor[i]), NEPH_OK);
  }
  assert_near_relative(factor[0], 0.8 / 0.5, 1e-12);
  assert_true(factor[1] < factor[0] / 8.0 && factor[1] > factor[0] / 64.0); /* between 3 and 6 stops */
  neph_image_destroy(image);
}

/* A ramp from black to four times white through each view, in 16 bits: the standard one clips at 1, the raw one is
 * linear as well and not exposed, the filmic one is the standard up to 0.75 and is not white by 1.5. */
static void views_map_light_as_they_say(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0, 0, 0);
  for (int i = 0; i < SIDE * SIDE; i++) set_pixel(image, i, (float)i / 1024, (float)i / 1024, (float)i / 1024);
  neph_preview_desc desc = make_plain_desc();
  neph_image *shown[3];
  desc.bits = 16;
  for (int view = NEPH_VIEW_FILMIC; view <= NEPH_VIEW_RAW; view++) {
    desc.view = (neph_view)view;
    desc.exposure = view == NEPH_VIEW_RAW ? NEPH_EXPOSURE_AUTO : NEPH_EXPOSURE_FIXED;
    shown[view] = save_and_load(f, image, &desc);
  }
  const double step = 2.0 / 65535.0; /* rounding, and a step of dither */
  for (int i = 0; i < SIDE * SIDE; i++) {
    const double light = i / 1024.0, clipped = fmin(light, 1.0);
    const double filmic = (double)shown[NEPH_VIEW_FILMIC]->channels[1].values[i];
    const double standard = (double)shown[NEPH_VIEW_STANDARD]->channels[1].values[i];
    assert_near(standard, encode_srgb(clipped), step);
    assert_near((double)shown[NEPH_VIEW_RAW]->channels[1].values[i], clipped, step);
    if (light <= 0.75) assert_near(filmic, standard, 2 * step);
    if (light > 0.8 && light < 1.5) assert_true(filmic < fmin(standard, 0.9985));
  }
  for (int view = 0; view < 3; view++) neph_image_destroy(shown[view]);
  neph_image_destroy(image);
}

static void picture_without_light_is_black(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0, 0, 0);
  assert_true(np_exposure_choose_by_picture(image, &plain) == 1.0);
  neph_image *loaded = save_and_load(f, image, NULL);
  for (unsigned c = 0; c < 3; c++) assert_true(average(loaded, c) == 0);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* ---- Errors of saving ---- */

static void bad_descriptions_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 1, 1, 1), *depth;
  static const char *const names[] = {"Z"};
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.white[1] = 0;
  assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "white of G is 0");
  desc = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure_ev = (double)NAN;
  assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "exposure", "[-64, 64]");
  desc = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
  desc.bits = 12;
  assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "bits are 12", "8 or 16");
  desc = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
  desc.view = (neph_view)5;
  assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "view is 5", "ocio (4)");
  assert_int_equal(neph_image_create(f->context, 4, 4, 1, names, &depth), NEPH_OK);
  assert_int_equal(neph_image_save_png(depth, f->path, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "R, G and B, or Y");
  assert_int_equal(test_folder_count(f->folder), 0);
  neph_image_destroy(depth);
  neph_image_destroy(image);
}

static void missing_folder_is_an_error(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 1, 1, 1);
  char *path = test_path(f->folder, "no/picture.png");
  assert_int_equal(neph_image_save_png(image, path, NULL), NEPH_ERROR_IO);
  assert_one_error(&f->log, path, "No such file or directory");
  neph_image_destroy(image);
  free(path);
}

static neph_result save_preview(const char *path, const void *image) { return neph_image_save_png(image, path, NULL); }

static void full_disk_leaves_nothing(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_colour(f->context, 0.2f, 0.3f, 0.4f);
  assert_survives_full_disk(f, 3000, 500, save_preview, image);
  neph_image_destroy(image);
}

#define PREVIEW_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      PREVIEW_TEST(middle_grey_shows_as_the_curve_says),
      PREVIEW_TEST(white_shows_as_neutral),
      PREVIEW_TEST(primaries_of_the_header_are_honoured),
      PREVIEW_TEST(tones_rise_and_keep_their_order),
      PREVIEW_TEST(negative_infinite_and_nan_pixels_are_safe),
      PREVIEW_TEST(gradients_do_not_band),
      PREVIEW_TEST(previews_repeat),
      PREVIEW_TEST(a_tile_shows_what_the_whole_does),
      PREVIEW_TEST(halves_show_what_their_file_does),
      PREVIEW_TEST(exposure_undoes_any_scale),
      PREVIEW_TEST(black_borders_and_the_sun_do_not_turn_the_exposure),
      PREVIEW_TEST(highlights_set_the_exposure),
      PREVIEW_TEST(the_meter_keeps_night_dark),
      PREVIEW_TEST(views_map_light_as_they_say),
      PREVIEW_TEST(picture_without_light_is_black),
      PREVIEW_TEST(bad_descriptions_are_refused),
      PREVIEW_TEST(missing_folder_is_an_error),
      PREVIEW_TEST(full_disk_leaves_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
