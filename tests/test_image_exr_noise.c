/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of noise return with their bits, through OpenEXRCore and through OpenImageIO: of widths and heights on both
 * sides of a chunk's, as halves and as floats, and with so much of the noise flattened that some chunks become as long
 * packed as they are raw. OpenImageIO's oiiotool is Debian's package openimageio-tools; where it is missing the test
 * says so and is skipped, but not by tests/run.sh, which installs it. */
#include "test_support.h"

#include <stdlib.h>

#include "core/half.h"
#include "core/random.h"
#include "image/image_private.h"

enum { CHANNELS = 3, LINES_PER_CHUNK = 16 };

static const char *const names[CHANNELS] = {"R", "G", "B"};
static const unsigned widths[] = {1, 2, 3, 7, 16, 255, 1000};
static const unsigned heights[] = {1, 15, 16, 17, 40};
enum {
  WIDTH_COUNT = sizeof widths / sizeof *widths,
  HEIGHT_COUNT = sizeof heights / sizeof *heights,
  PICTURE_COUNT = WIDTH_COUNT * HEIGHT_COUNT
};

static int set_up(void **state) { return test_set_up(state, 2, "noise.exr"); }

/* ---- Noise ---- */

/* Any bits that are a finite number of the type: subnormals and zeros of either sign are among them. */
static float choose_value(np_random *random, neph_pixel_type type) {
  uint32_t bits = (uint32_t)np_random_bits(random);
  if (type == NEPH_PIXEL_HALF) {
    const uint16_t half = (uint16_t)bits;
    return np_half_to_float((half & 0x7c00u) == 0x7c00u ? half ^ 0x4000u : half);
  }
  if ((bits & 0x7f800000u) == 0x7f800000u) bits ^= 0x40000000u;
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* In each chunk another share of the values, a half to all, is noise, the others being 1. */
static neph_image *create_noise(neph_context *context, unsigned width, unsigned height, neph_pixel_type type,
                                uint64_t seed) {
  neph_image *image;
  assert_int_equal(neph_image_create(context, width, height, CHANNELS, names, &image), NEPH_OK);
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  float share = 1.0f;
  for (unsigned y = 0; y < height; y++) {
    if (y % LINES_PER_CHUNK == 0) share = 0.5f + 0.5f * np_random_float(&random);
    for (unsigned i = 0; i < CHANNELS * width; i++) {
      const float value = choose_value(&random, type);
      image->channels[i % CHANNELS].values[(size_t)y * width + i / CHANNELS] =
          np_random_float(&random) < share ? value : 1.0f;
    }
  }
  return image;
}

static void assert_same_bits(neph_image *image, const neph_image *expected) {
  assert_int_equal(image->width, expected->width);
  assert_int_equal(image->height, expected->height);
  assert_int_equal(image->channel_count, CHANNELS);
  for (unsigned c = 0; c < CHANNELS; c++) {
    const float *values = neph_image_get_channel(image, names[c]);
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
      if (memcmp(&values[i], &expected->channels[c].values[i], sizeof *values))
        fail_msg("%u × %u, channel %s, value %zu is %a, was %a", image->width, image->height, names[c], i,
                 (double)values[i], (double)expected->channels[c].values[i]);
  }
}

static void assert_file_is(neph_context *context, const char *path, const neph_image *expected) {
  neph_image *image;
  assert_int_equal(neph_image_load_exr(context, path, &image), NEPH_OK);
  assert_same_bits(image, expected);
  neph_image_destroy(image);
}

/* ---- Through OpenEXRCore ---- */

static void noise_returns_with_its_bits(void **state) {
  test_fixture *f = *state;
  for (int type = NEPH_PIXEL_HALF; type <= NEPH_PIXEL_FLOAT; type++)
    for (unsigned i = 0; i < PICTURE_COUNT; i++) {
      neph_image *image =
          create_noise(f->context, widths[i / HEIGHT_COUNT], heights[i % HEIGHT_COUNT], (neph_pixel_type)type, i);
      assert_int_equal(neph_image_save_exr(image, f->path, (neph_pixel_type)type), NEPH_OK);
      assert_file_is(f->context, f->path, image);
      neph_image_destroy(image);
    }
}

/* The tall ones have 4096 chunks of 96 or 192 bytes, of which some are as long packed as raw. */
static void the_tallest_and_the_widest_picture_return(void **state) {
  test_fixture *f = *state;
  for (int type = NEPH_PIXEL_HALF; type <= NEPH_PIXEL_FLOAT; type++)
    for (int is_wide = 0; is_wide <= 1; is_wide++) {
      neph_image *image = create_noise(f->context, is_wide ? NP_IMAGE_SIDE_MAX : 1, is_wide ? 1 : NP_IMAGE_SIDE_MAX,
                                       (neph_pixel_type)type, 7);
      assert_int_equal(neph_image_save_exr(image, f->path, (neph_pixel_type)type), NEPH_OK);
      assert_file_is(f->context, f->path, image);
      neph_image_destroy(image);
    }
}

static void flat_pictures_return(void **state) {
  test_fixture *f = *state;
  const float values[] = {0.0f, -0.0f, 1.0f, 65504.0f};
  for (size_t v = 0; v < sizeof values / sizeof *values; v++)
    for (int type = NEPH_PIXEL_HALF; type <= NEPH_PIXEL_FLOAT; type++)
      for (unsigned i = 0; i < PICTURE_COUNT; i++) {
        neph_image *image;
        const unsigned width = widths[i / HEIGHT_COUNT], height = heights[i % HEIGHT_COUNT];
        assert_int_equal(neph_image_create(f->context, width, height, CHANNELS, names, &image), NEPH_OK);
        for (size_t k = 0; k < (size_t)CHANNELS * width * height; k++)
          image->channels[k % CHANNELS].values[k / CHANNELS] = values[v];
        assert_int_equal(neph_image_save_exr(image, f->path, (neph_pixel_type)type), NEPH_OK);
        assert_file_is(f->context, f->path, image);
        neph_image_destroy(image);
      }
}

/* ---- Through OpenImageIO ---- */

static void require_oiiotool(void) {
  if (system("oiiotool --help >/dev/null 2>&1") == 0) return;
  print_message("skipped: `oiiotool --help` fails; the package is openimageio-tools\n");
  if (getenv("NEPHOS_REQUIRE_TOOLS")) fail_msg("openimageio-tools is required here");
  skip();
}

/* A tall version of the last picture: its chunks are small and many. */
static neph_image *create_picture(neph_context *context, unsigned index, neph_pixel_type type) {
  const bool is_tall = index == PICTURE_COUNT;
  return create_noise(context, is_tall ? 1 : widths[index / HEIGHT_COUNT],
                      is_tall ? NP_IMAGE_SIDE_MAX : heights[index % HEIGHT_COUNT], type, 100 + index);
}

static char *name_picture(const test_fixture *f, unsigned index, const char *kind) {
  char name[32];
  snprintf(name, sizeof name, "%u.%s.exr", index, kind);
  return test_path(f->folder, name);
}

/* Has OpenImageIO read every picture, and write what it read with a codec. */
static void copy_pictures(const test_fixture *f, const char *codec) {
  char *line = NULL;
  size_t size;
  FILE *out = open_memstream(&line, &size);
  fprintf(out, "cd '%s' && oiiotool --compression %s", f->folder, codec);
  for (unsigned i = 0; i <= PICTURE_COUNT; i++) fprintf(out, " %u.nephos.exr -o %u.%s.exr", i, i, codec);
  fclose(out);
  assert_int_equal(system(line), 0);
  free(line);
}

static void check_copies(test_fixture *f, neph_pixel_type type, const char *codec) {
  copy_pictures(f, codec);
  for (unsigned i = 0; i <= PICTURE_COUNT; i++) {
    neph_image *image = create_picture(f->context, i, type);
    char *path = name_picture(f, i, codec);
    assert_file_is(f->context, path, image);
    free(path);
    neph_image_destroy(image);
  }
}

/* The copy without a codec holds what OpenImageIO read; those with one are for our reader. PXR24 keeps halves alone. */
static void openimageio_reads_and_writes_the_same_bits(void **state) {
  static const char *const codecs[] = {"none", "rle", "zips", "zip", "piz", "pxr24"};
  test_fixture *f = *state;
  require_oiiotool();
  for (int type = NEPH_PIXEL_HALF; type <= NEPH_PIXEL_FLOAT; type++) {
    for (unsigned i = 0; i <= PICTURE_COUNT; i++) {
      neph_image *image = create_picture(f->context, i, (neph_pixel_type)type);
      char *path = name_picture(f, i, "nephos");
      assert_int_equal(neph_image_save_exr(image, path, (neph_pixel_type)type), NEPH_OK);
      free(path);
      neph_image_destroy(image);
    }
    for (unsigned c = 0; c < sizeof codecs / sizeof *codecs - (type == NEPH_PIXEL_FLOAT); c++)
      check_copies(f, (neph_pixel_type)type, codecs[c]);
  }
}

#define NOISE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      NOISE_TEST(noise_returns_with_its_bits),
      NOISE_TEST(the_tallest_and_the_widest_picture_return),
      NOISE_TEST(flat_pictures_return),
      NOISE_TEST(openimageio_reads_and_writes_the_same_bits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
