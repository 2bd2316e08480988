/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels of a preview in memory against those of its file. */
#include <nephos/exposure.h>

#include "test_support.h"

#include <stdlib.h>

#include "image/color_space.h"
#include "image/image_private.h"

static int set_up(void **state) { return test_set_up(state, 2, "picture.png"); }

enum { WIDTH = 240, HEIGHT = 150, STRIDE = 4 * WIDTH + 12 };

/* Colours of every hue, twenty stops up the rows, black in one column. */
static neph_image *create_picture(neph_context *context) {
  static const char *const names[] = {"R", "G", "B"};
  neph_image *image;
  assert_int_equal(neph_image_create(context, WIDTH, HEIGHT, 3, names, &image), NEPH_OK);
  for (int y = 0; y < HEIGHT; y++)
    for (int x = 0; x < WIDTH; x++) {
      const double light = exp2(20.0 * y / HEIGHT - 15.0), hue = 6.2831853 * x / WIDTH;
      for (int c = 0; c < 3; c++)
        image->channels[c].values[y * WIDTH + x] = x ? (float)(light * (0.6 + 0.7 * cos(hue + 2.1 * c))) : 0.0f;
    }
  return image;
}

static uint8_t *develop(const neph_image *image, const neph_preview_desc *desc) {
  uint8_t *pixels = calloc(HEIGHT, STRIDE);
  assert_non_null(pixels);
  assert_int_equal(neph_image_develop(image, desc, 0, 0, WIDTH, HEIGHT, pixels, STRIDE), NEPH_OK);
  return pixels;
}

/* Components within a step of 1/255 of the file's, whose dither is less than a step, and nearest to its 16-bit ones,
 * whose dither is less than a 257th; the table's limits are floats. */
static void check_pixels(test_fixture *f, const neph_image *image, neph_preview_desc desc) {
  uint8_t *pixels = develop(image, &desc);
  for (unsigned bits = 8; bits <= 16; bits += 8) {
    const double tolerance = bits == 8 ? 1.0 + 1e-3 : 0.5 + 1.5 / 257.0 + 1e-3;
    neph_image *loaded;
    desc.bits = bits;
    assert_int_equal(neph_image_save_png(image, f->path, &desc), NEPH_OK);
    assert_int_equal(neph_image_load_png(f->context, f->path, &loaded), NEPH_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      const uint8_t *pixel = &pixels[i / WIDTH * STRIDE + i % WIDTH * 4];
      assert_int_equal(pixel[3], 255);
      for (int c = 0; c < 3; c++)
        assert_near((double)pixel[c], 255.0 * (double)loaded->channels[c].values[i], tolerance);
    }
    neph_image_destroy(loaded);
  }
  free(pixels);
}

static void pixels_are_those_of_the_file(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  for (int view = NEPH_VIEW_FILMIC; view <= NEPH_VIEW_CAMERA; view++)
    for (int stops = -3; stops <= 3; stops += 2) {
      neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
      desc.view = (neph_view)view;
      desc.exposure = stops > 0 ? NEPH_EXPOSURE_AUTO : NEPH_EXPOSURE_FIXED;
      desc.exposure_ev = stops;
      desc.white[0] = 1.25;
      check_pixels(f, image, desc);
    }
  neph_image_destroy(image);
}

static void wide_primaries_too(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  image->header.has_chromaticities = true;
  memcpy(image->header.chromaticities, np_color_space_get_chromaticities(NP_COLOR_ACESCG),
         sizeof image->header.chromaticities);
  check_pixels(f, image, (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT);
  neph_image_destroy(image);
}

static void rectangles_are_those_of_the_whole(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  uint8_t *whole = develop(image, NULL), *tiled = calloc(HEIGHT, STRIDE);
  for (unsigned y = 0; y < HEIGHT; y += 32)
    for (unsigned x = 0; x < WIDTH; x += 56) {
      const unsigned x1 = x + 56 < WIDTH ? x + 56 : WIDTH, y1 = y + 32 < HEIGHT ? y + 32 : HEIGHT;
      assert_int_equal(neph_image_develop(image, NULL, x, y, x1, y1, tiled + y * STRIDE + 4 * x, STRIDE), NEPH_OK);
    }
  assert_memory_equal(tiled, whole, (size_t)HEIGHT * STRIDE); /* bytes between rows as well, which stay 0 */
  free(tiled);
  free(whole);
  neph_image_destroy(image);
}

/* A picture whose lower half is not rendered yet has the exposure of its upper half, which can be held. */
static void an_exposure_is_held_while_a_picture_grows(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  neph_preview_desc held = NEPH_PREVIEW_DESC_DEFAULT;
  double stops = 0.0, stops_at_the_end = 0.0;
  for (int c = 0; c < 3; c++)
    memset(image->channels[c].values + WIDTH * HEIGHT / 2, 0, WIDTH * HEIGHT / 2 * sizeof(float));
  assert_int_equal(neph_image_compute_exposure(image, NULL, &stops), NEPH_OK);
  held.exposure = NEPH_EXPOSURE_FIXED;
  held.exposure_ev = stops;
  uint8_t *by_picture = develop(image, NULL), *by_number = develop(image, &held);
  assert_memory_equal(by_picture, by_number, (size_t)HEIGHT * STRIDE);
  neph_image *finished = create_picture(f->context);
  assert_int_equal(neph_image_compute_exposure(finished, NULL, &stops_at_the_end), NEPH_OK);
  assert_true(stops - stops_at_the_end > 5.0); /* rows end ten stops lower */
  uint8_t *later = develop(finished, &held);
  assert_memory_equal(later, by_number, (size_t)HEIGHT / 2 * STRIDE);
  free(later);
  free(by_number);
  free(by_picture);
  neph_image_destroy(finished);
  neph_image_destroy(image);
}

static void odd_values_have_their_colours(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  const float odd[3] = {NAN, HUGE_VALF, -1.0f};
  const uint8_t shown[3][4] = {{255, 0, 255, 255}, {255, 255, 255, 255}, {0, 0, 0, 255}};
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < 3; c++) image->channels[c].values[i] = odd[i];
  uint8_t *pixels = develop(image, NULL);
  assert_memory_equal(pixels, shown, sizeof shown);
  free(pixels);
  neph_image_destroy(image);
}

static void what_is_no_rectangle_is_refused(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"Z"};
  neph_image *image = create_picture(f->context), *depth;
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  uint8_t pixels[64] = {0};
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  assert_int_equal(neph_image_develop(image, NULL, 0, 0, WIDTH + 1, 1, pixels, STRIDE), bad);
  assert_non_null(
      strstr(f->log.text, "columns 0 to 241 and rows 0 to 1 are no rectangle of a picture of 240 × 150 pixels"));
  assert_int_equal(neph_image_develop(image, NULL, 0, HEIGHT, 1, HEIGHT + 1, pixels, STRIDE), bad);
  assert_int_equal(neph_image_develop(image, NULL, 4, 0, 4, 1, pixels, STRIDE), bad);
  assert_int_equal(neph_image_develop(image, NULL, 0, 0, 4, 1, pixels, 15), bad);
  assert_non_null(strstr(f->log.text, "the stride is 15 bytes, must be at least 4 for each of 4 pixels"));
  desc.exposure_ev = 65;
  assert_int_equal(neph_image_develop(image, &desc, 0, 0, 4, 1, pixels, 16), bad);
  desc = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure = NEPH_EXPOSURE_METER; /* the picture has no meter */
  assert_int_equal(neph_image_develop(image, &desc, 0, 0, 4, 1, pixels, 16), bad);
  assert_int_equal(neph_image_create(f->context, 4, 1, 1, names, &depth), NEPH_OK);
  assert_int_equal(neph_image_develop(depth, NULL, 0, 0, 4, 1, pixels, 16), bad);
  assert_non_null(strstr(f->log.text, "a preview needs the channels R, G and B, or Y"));
  neph_image_destroy(depth);
  neph_image_destroy(image);
}

#define DEVELOP_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      DEVELOP_TEST(pixels_are_those_of_the_file),      DEVELOP_TEST(wide_primaries_too),
      DEVELOP_TEST(rectangles_are_those_of_the_whole), DEVELOP_TEST(an_exposure_is_held_while_a_picture_grows),
      DEVELOP_TEST(odd_values_have_their_colours),     DEVELOP_TEST(what_is_no_rectangle_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
