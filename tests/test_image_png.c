/* SPDX-License-Identifier: Apache-2.0 */
/* PNG files that are read. */
#include "test_support.h"

#include <fcntl.h>
#include <png.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "core/random.h"
#include "image/picture_decoder.h"
#include "nephos/image.h"

static int set_up(void **state) { return test_set_up(state, 2, "picture.png"); }

/* ---- Files to read ---- */

enum { WIDTH = 19, HEIGHT = 11, ROW_BYTES_MAX = WIDTH * 8 };

typedef struct png_kind {
  int colour_type, bits, interlace;
} png_kind;

static unsigned count_samples(int colour_type) {
  switch (colour_type) {
  case PNG_COLOR_TYPE_GRAY_ALPHA:
    return 2;
  case PNG_COLOR_TYPE_RGB:
    return 3;
  case PNG_COLOR_TYPE_RGB_ALPHA:
    return 4;
  default:
    return 1;
  }
}

/* Sample `index` of a row, as the file holds it. */
static unsigned choose_sample(unsigned y, unsigned index, int bits) {
  return (unsigned)np_random_mix((uint64_t)y << 32 | index) & ((1u << bits) - 1);
}

static void put_sample(uint8_t *row, unsigned index, int bits, unsigned sample) {
  unsigned at = index * (unsigned)bits;
  if (bits == 16)
    row[at / 8] = (uint8_t)(sample >> 8), row[at / 8 + 1] = (uint8_t)sample;
  else
    row[at / 8] |= (uint8_t)(sample << (8 - bits - (int)(at % 8)));
}

/* Entry i of the palette. */
static png_color choose_colour(unsigned i) {
  return (png_color){.red = (png_byte)(7 * i), .green = (png_byte)(255 - i), .blue = (png_byte)(i * i)};
}

static void write_png(const char *path, png_kind kind) {
  static uint8_t bytes[HEIGHT][ROW_BYTES_MAX];
  png_bytep rows[HEIGHT];
  png_color palette[256];
  FILE *file = fopen(path, "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
  png_infop info = png_create_info_struct(png);
  memset(bytes, 0, sizeof bytes);
  for (unsigned y = 0; y < HEIGHT; y++) {
    rows[y] = bytes[y];
    for (unsigned i = 0; i < WIDTH * count_samples(kind.colour_type); i++)
      put_sample(bytes[y], i, kind.bits, choose_sample(y, i, kind.bits));
  }
  for (unsigned i = 0; i < 256; i++) palette[i] = choose_colour(i);
  png_init_io(png, file);
  png_set_IHDR(png, info, WIDTH, HEIGHT, kind.bits, kind.colour_type, kind.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (kind.colour_type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 1 << kind.bits);
  png_set_gAMA(png, info, 0.45455); /* which must change no value */
  png_set_rows(png, info, rows);
  png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
  png_destroy_write_struct(&png, &info);
  assert_int_equal(fclose(file), 0);
}

static const char *name_channel(int colour_type, unsigned c) {
  static const char *const grey[] = {"Y", "A"}, *const colour[] = {"R", "G", "B", "A"};
  bool is_grey = colour_type == PNG_COLOR_TYPE_GRAY || colour_type == PNG_COLOR_TYPE_GRAY_ALPHA;
  return is_grey ? grey[c] : colour[c];
}

static float get_expected(png_kind kind, unsigned x, unsigned y, unsigned c) {
  if (kind.colour_type != PNG_COLOR_TYPE_PALETTE) {
    unsigned sample = choose_sample(y, x * count_samples(kind.colour_type) + c, kind.bits);
    return (float)sample / (float)((1 << kind.bits) - 1);
  }
  png_color colour = choose_colour(choose_sample(y, x, kind.bits));
  const png_byte parts[3] = {colour.red, colour.green, colour.blue};
  return (float)parts[c] / 255.0f;
}

static void check_kind(test_fixture *f, png_kind kind) {
  neph_image *image;
  write_png(f->path, kind);
  assert_int_equal(neph_image_load_png(f->context, f->path, &image), NEPH_OK);
  unsigned count = kind.colour_type == PNG_COLOR_TYPE_PALETTE ? 3 : count_samples(kind.colour_type);
  assert_int_equal(neph_image_get_channel_count(image), count);
  assert_int_equal(neph_image_get_width(image), WIDTH);
  assert_int_equal(neph_image_get_height(image), HEIGHT);
  for (unsigned c = 0; c < count; c++) {
    const float *values = neph_image_get_channel(image, name_channel(kind.colour_type, c));
    assert_non_null(values);
    for (unsigned i = 0; i < WIDTH * HEIGHT; i++)
      assert_true(values[i] == get_expected(kind, i % WIDTH, i / WIDTH, c)); /* one division, correctly rounded */
  }
  neph_image_destroy(image);
}

static void every_kind_is_read_exactly(void **state) {
  const png_kind kinds[] = {
      {PNG_COLOR_TYPE_GRAY, 1, 0},        {PNG_COLOR_TYPE_GRAY, 2, 0},       {PNG_COLOR_TYPE_GRAY, 4, 0},
      {PNG_COLOR_TYPE_GRAY, 8, 0},        {PNG_COLOR_TYPE_GRAY, 16, 0},      {PNG_COLOR_TYPE_PALETTE, 1, 0},
      {PNG_COLOR_TYPE_PALETTE, 4, 0},     {PNG_COLOR_TYPE_PALETTE, 8, 0},    {PNG_COLOR_TYPE_GRAY_ALPHA, 8, 0},
      {PNG_COLOR_TYPE_GRAY_ALPHA, 16, 0}, {PNG_COLOR_TYPE_RGB, 8, 0},        {PNG_COLOR_TYPE_RGB, 16, 0},
      {PNG_COLOR_TYPE_RGB_ALPHA, 8, 0},   {PNG_COLOR_TYPE_RGB_ALPHA, 16, 0},
  };
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    png_kind kind = kinds[i];
    check_kind(*state, kind);
    kind.interlace = PNG_INTERLACE_ADAM7;
    check_kind(*state, kind);
  }
}

/* ---- Damaged files ---- */

/* The decoder itself, in this process, where a sanitizer sees it. */
static neph_result decode(neph_context *context, const char *path, neph_image **out_image) {
  return np_image_decode_png(context, open(path, O_RDONLY | O_CLOEXEC), path, out_image);
}

static void every_prefix_is_an_error(void **state) {
  test_fixture *f = *state;
  write_png(f->path, (png_kind){PNG_COLOR_TYPE_RGB_ALPHA, 16, PNG_INTERLACE_ADAM7});
  test_file file = test_file_read(f->path);
  for (size_t size = 0; size < file.size; size++) {
    neph_image *image;
    test_file_write(f->path, file.bytes, size);
    assert_int_equal(decode(f->context, f->path, &image), NEPH_ERROR_BAD_FILE);
    assert_null(image);
    assert_one_error(&f->log, f->path, "damaged, cut short or no PNG");
  }
  free(file.bytes);
}

static neph_result decode_and_destroy(neph_context *context, const char *path) {
  neph_image *image;
  const neph_result result = decode(context, path, &image);
  neph_image_destroy(image);
  return result;
}

static neph_result load_and_destroy(neph_context *context, const char *path) {
  neph_image *image;
  const neph_result result = neph_image_load_png(context, path, &image);
  neph_image_destroy(image);
  return result;
}

static void flipped_bytes_are_survived(void **state) {
  test_fixture *f = *state;
  write_png(f->path, (png_kind){PNG_COLOR_TYPE_PALETTE, 8, 0});
  assert_survives_changed_bytes(f, SIZE_MAX, 2000, decode_and_destroy);
  assert_survives_changed_bytes(f, SIZE_MAX, 50, load_and_destroy);
}

/* Width and height stand behind the signature, the chunk's length and its name; the checksum behind its 13 bytes. */
static void huge_claims_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  write_png(f->path, (png_kind){PNG_COLOR_TYPE_RGB, 8, 0});
  test_file file = test_file_read(f->path);
  file.bytes[16] = 0x7f;
  png_uint_32 sum = 0xffffffffu;
  for (int i = 12; i < 29; i++) {
    sum ^= file.bytes[i];
    for (int bit = 0; bit < 8; bit++) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0);
  }
  for (int i = 0; i < 4; i++) file.bytes[29 + i] = (uint8_t)(~sum >> (24 - 8 * i));
  test_file_write(f->path, file.bytes, file.size);
  assert_int_equal(neph_image_load_png(f->context, f->path, &image), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "claims 2130706451 × 11", "1 to 65536 each way");
  free(file.bytes);
}

static void *refuse_large_blocks(void *user, void *block, size_t old_bytes, size_t new_bytes) {
  enum { BYTES_MAX = 32000000 };
  return new_bytes > BYTES_MAX ? NULL : test_allocator_reallocate(user, block, old_bytes, new_bytes);
}

/* A text of 1 GB is announced behind the 33 bytes of signature and header, in a file of 61 bytes. */
static void a_chunk_longer_than_its_file_takes_no_memory(void **state) {
  static const uint8_t text[8] = {0x41, 0, 0, 0, 't', 'E', 'X', 't'};
  test_fixture *f = *state;
  test_allocator allocator = {0};
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  neph_image *image;
  desc.reallocate = refuse_large_blocks;
  desc.reallocate_user = &allocator;
  desc.log = test_log_receive;
  desc.log_user = &f->log;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  write_png(f->path, (png_kind){PNG_COLOR_TYPE_RGB, 8, 0});
  test_file file = test_file_read(f->path);
  memcpy(file.bytes + 33, text, sizeof text);
  test_file_write(f->path, file.bytes, 61);
  assert_int_equal(decode(context, f->path, &image), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "damaged, cut short or no PNG");
  free(file.bytes);
  neph_context_destroy(context);
}

static void missing_file_is_not_found(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  assert_int_equal(neph_image_load_png(f->context, f->path, &image), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, f->path);
  assert_null(image);
}

/* ---- Memory ---- */

static neph_result save_and_load_grey(neph_context *context, void *user) {
  static const char *const names[] = {"Y"};
  neph_image *image = NULL, *loaded = NULL;
  neph_result result = neph_image_create(context, 8, 8, 1, names, &image);
  if (!result) result = neph_image_save_png(image, user, NULL);
  if (!result) result = neph_image_load_png(context, user, &loaded);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
  return result;
}

static void failed_allocations_are_survived(void **state) {
  test_fixture *f = *state;
  assert_survives_failed_allocations(save_and_load_grey, f->path);
  assert_int_equal(test_folder_count(f->folder), 1);
}

#define PNG_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      PNG_TEST(every_kind_is_read_exactly),
      PNG_TEST(every_prefix_is_an_error),
      PNG_TEST(flipped_bytes_are_survived),
      PNG_TEST(huge_claims_are_refused),
      PNG_TEST(a_chunk_longer_than_its_file_takes_no_memory),
      PNG_TEST(missing_file_is_not_found),
      PNG_TEST(failed_allocations_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
