/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR files as other programs write them: tiles, every codec, halves, floats and integers. */
#include "test_support.h"

#include <openexr_encode.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "image/image_private.h"

enum { WIDTH = 83, HEIGHT = 71, TILE_WIDTH = 32, TILE_HEIGHT = 24, CHANNELS = 3 };

static int set_up(void **state) { return test_set_up(state, 2, "foreign.exr"); }

typedef struct foreign_kind {
  exr_compression_t compression;
  bool is_tiled;
  double tolerance; /* relative, of codecs that lose digits */
} foreign_kind;

static const exr_pixel_type_t types[CHANNELS] = {EXR_PIXEL_FLOAT, EXR_PIXEL_HALF, EXR_PIXEL_UINT};
static const char *const names[CHANNELS] = {"a", "b", "c"};

/* Smooth, so that lossy codecs stay close, and exact in every type: integers from 1 to 1500. */
static unsigned choose_value(int c, int x, int y) { return 1 + (unsigned)(5 * x + 7 * y + 100 * c); }

typedef struct foreign_planes {
  float values[CHANNELS][WIDTH * HEIGHT]; /* integers in their own bits */
} foreign_planes;

static void fill_planes(foreign_planes *planes) {
  for (int c = 0; c < CHANNELS; c++)
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      uint32_t integer = choose_value(c, i % WIDTH, i / WIDTH);
      if (types[c] == EXR_PIXEL_UINT)
        memcpy(&planes->values[c][i], &integer, sizeof integer);
      else
        planes->values[c][i] = (float)integer;
    }
}

static void write_chunk(exr_context_t exr, const exr_chunk_info_t *info, const foreign_planes *planes, int x, int y) {
  exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
  assert_int_equal(exr_encoding_initialize(exr, 0, info, &pipeline), 0);
  for (int c = 0; c < CHANNELS; c++) {
    exr_coding_channel_info_t *channel = &pipeline.channels[c];
    channel->user_bytes_per_element = sizeof(float);
    channel->user_pixel_stride = sizeof(float);
    channel->user_data_type = types[c] == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
    channel->user_line_stride = WIDTH * sizeof(float);
    channel->encode_from_ptr = (const uint8_t *)&planes->values[c][y * WIDTH + x];
  }
  assert_int_equal(exr_encoding_choose_default_routines(exr, 0, &pipeline), 0);
  assert_int_equal(exr_encoding_run(exr, 0, &pipeline), 0);
  assert_int_equal(exr_encoding_destroy(exr, &pipeline), 0);
}

static void write_pixels(exr_context_t exr, bool is_tiled) {
  static foreign_planes planes;
  exr_chunk_info_t info;
  int32_t lines;
  fill_planes(&planes);
  assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &lines), is_tiled ? EXR_ERR_SCAN_TILE_MIXEDAPI : 0);
  for (int y = 0; y < HEIGHT; y += is_tiled ? TILE_HEIGHT : lines)
    for (int x = 0; x < WIDTH; x += is_tiled ? TILE_WIDTH : WIDTH) {
      exr_result_t code = is_tiled ? exr_write_tile_chunk_info(exr, 0, x / TILE_WIDTH, y / TILE_HEIGHT, 0, 0, &info)
                                   : exr_write_scanline_chunk_info(exr, 0, y, &info);
      assert_int_equal(code, 0);
      write_chunk(exr, &info, &planes, x, y);
    }
}

static void ignore(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)exr, (void)code, (void)message;
}

static void write_foreign(const char *path, foreign_kind kind) {
  exr_context_t exr;
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  int part;
  initializer.error_handler_fn = ignore;
  assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &initializer), 0);
  assert_int_equal(exr_add_part(exr, NULL, kind.is_tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part), 0);
  assert_int_equal(exr_initialize_required_attr_simple(exr, 0, WIDTH, HEIGHT, kind.compression), 0);
  if (kind.is_tiled)
    assert_int_equal(exr_set_tile_descriptor(exr, 0, TILE_WIDTH, TILE_HEIGHT, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN),
                     0);
  for (int c = 0; c < CHANNELS; c++)
    assert_int_equal(exr_add_channel(exr, 0, names[c], types[c], EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), 0);
  assert_int_equal(exr_attr_set_double(exr, 0, "focus", 0.5), 0);
  assert_int_equal(exr_write_header(exr), 0);
  write_pixels(exr, kind.is_tiled);
  assert_int_equal(exr_finish(&exr), 0);
}

static void check_kind(test_fixture *f, foreign_kind kind) {
  neph_image *image;
  write_foreign(f->path, kind);
  assert_int_equal(neph_image_load_exr(f->context, f->path, &image), NEPH_OK);
  assert_int_equal(neph_image_get_channel_count(image), CHANNELS);
  assert_string_equal(neph_image_get_attribute(image, "focus"), "0.5");
  for (int c = 0; c < CHANNELS; c++) {
    const float *values = neph_image_get_channel(image, names[c]);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
      assert_near_relative(values[i], choose_value(c, i % WIDTH, i / WIDTH), kind.tolerance);
  }
  neph_image_destroy(image);
}

/* PXR24 cuts a float to 24 bits, which these integers fit. B44 keeps differences within 4 × 4 halves in six bits, so it
 * may err by 2⁻⁵ of a block's largest value, which is up to 1.5 times the least. */
static void scan_lines_and_tiles_of_every_codec_are_read(void **state) {
  const foreign_kind kinds[] = {
      {EXR_COMPRESSION_NONE, false, 0},   {EXR_COMPRESSION_RLE, false, 0},     {EXR_COMPRESSION_ZIPS, false, 0},
      {EXR_COMPRESSION_ZIP, false, 0},    {EXR_COMPRESSION_PIZ, false, 0},     {EXR_COMPRESSION_PXR24, false, 0},
      {EXR_COMPRESSION_B44, false, 0.05}, {EXR_COMPRESSION_B44A, false, 0.05},
  };
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    foreign_kind kind = kinds[i];
    check_kind(*state, kind);
    kind.is_tiled = true;
    check_kind(*state, kind);
  }
}

static void descriptions_name_tiles_and_codec(void **state) {
  test_fixture *f = *state;
  char *text;
  write_foreign(f->path, (foreign_kind){EXR_COMPRESSION_PIZ, true, 0});
  assert_int_equal(neph_image_describe_file(f->context, f->path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_non_null(strstr(text, "83 x 71 pixels, tiles, PIZ compression"));
  assert_non_null(strstr(text, "32 x 24"));
  assert_non_null(strstr(text, "a (float), b (half), c (uint)"));
  neph_text_destroy(f->context, text);
}

static neph_result load_and_destroy(neph_context *context, const char *path) {
  neph_image *image;
  const neph_result result = neph_image_load_exr(context, path, &image);
  neph_image_destroy(image);
  return result;
}

/* Results allowed for a damaged file, with memory enough. */
static neph_result load_damaged(neph_context *context, const char *path) {
  const neph_result result = load_and_destroy(context, path);
  if (result && result != NEPH_ERROR_BAD_FILE && result != NEPH_ERROR_UNSUPPORTED)
    fail_msg("a damaged file is %s", neph_result_get_name(result));
  return result;
}

/* The codecs' own decoders on damaged chunks: an error or a picture, never a crash, and never "no memory". */
static void flipped_bytes_are_survived(void **state) {
  test_fixture *f = *state;
  for (int compression = EXR_COMPRESSION_NONE; compression <= EXR_COMPRESSION_B44A; compression++) {
    write_foreign(f->path, (foreign_kind){(exr_compression_t)compression, compression % 2, 0});
    assert_survives_changed_bytes(f, SIZE_MAX, 300, load_damaged);
  }
}

#define FOREIGN_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      FOREIGN_TEST(scan_lines_and_tiles_of_every_codec_are_read),
      FOREIGN_TEST(descriptions_name_tiles_and_codec),
      FOREIGN_TEST(flipped_bytes_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
