/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "core/half.h"
#include "core/random.h"
#include "image/image_private.h"
#include "image/picture_decoder.h"

enum { WIDTH = 45, HEIGHT = 37 }; /* two chunks of 16 lines and a ragged one */

static const char *const rgbaz[] = {"R", "G", "B", "A", "Z", "sun.R"};
enum { RGBAZ_COUNT = sizeof rgbaz / sizeof *rgbaz };

static int set_up(void **state) { return test_set_up(state, 2, "picture.exr"); }

/* A picture of plausible radiances: positive, over several decades. */
static neph_image *create_picture(neph_context *context) {
  neph_image *image;
  assert_int_equal(neph_image_create(context, WIDTH, HEIGHT, RGBAZ_COUNT, rgbaz, &image), NEPH_OK);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (unsigned c = 0; c < RGBAZ_COUNT; c++)
    for (int i = 0; i < WIDTH * HEIGHT; i++)
      image->channels[c].values[i] = powf(10.0f, 4.0f * np_random_float(&random) - 3.0f);
  return image;
}

static neph_image *load(test_fixture *f) {
  neph_image *image;
  assert_int_equal(neph_image_load_exr(f->context, f->path, &image), NEPH_OK);
  return image;
}

static void save(test_fixture *f, const neph_image *image, neph_pixel_type type) {
  assert_int_equal(neph_image_save_exr(image, f->path, type), NEPH_OK);
}

static uint32_t get_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

/* ---- Images ---- */

static void images_begin_black_and_know_their_channels(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, 3, 2, RGBAZ_COUNT, rgbaz, &image), NEPH_OK);
  assert_int_equal(neph_image_get_width(image), 3);
  assert_int_equal(neph_image_get_height(image), 2);
  assert_int_equal(neph_image_get_channel_count(image), RGBAZ_COUNT);
  assert_string_equal(neph_image_get_channel_name(image, 5), "sun.R");
  assert_null(neph_image_get_channel_name(image, RGBAZ_COUNT));
  assert_null(neph_image_get_channel(image, "sun.G"));
  for (int i = 0; i < 6; i++) assert_true(neph_image_get_channel(image, "Z")[i] == 0);
  neph_image_destroy(image);
  neph_image_destroy(NULL);
}

static void impossible_images_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  const char *const twice[] = {"R", "G", "R"}, *const nameless[] = {""};
  assert_int_equal(neph_image_create(f->context, 0, 1, 1, rgbaz, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "0 × 1", "1 to 65536");
  assert_int_equal(neph_image_create(f->context, 1, 65537, 1, rgbaz, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "1 × 65537");
  assert_int_equal(neph_image_create(f->context, 65536, 65536, 1, rgbaz, &image), NEPH_OK);
  neph_image_destroy(image);
  assert_int_equal(neph_image_create(f->context, 65536, 65536, 2, rgbaz, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "16 GiB");
  assert_int_equal(neph_image_create(f->context, 1, 1, 0, rgbaz, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "0 channels");
  assert_int_equal(neph_image_create(f->context, 1, 1, 3, twice, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "\"R\" is named twice");
  assert_int_equal(neph_image_create(f->context, 1, 1, 1, nameless, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "channel name 0");
  assert_null(image);
}

static void attributes_are_set_and_replaced(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, 1, 1, 1, rgbaz, &image), NEPH_OK);
  assert_null(neph_image_get_attribute(image, "nephos:isa"));
  assert_int_equal(neph_image_set_attribute(image, "nephos:isa", "x86-64"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, "nephos:isa", "x86-64-v3"), NEPH_OK);
  assert_int_equal(np_image_set_real(image, "renderTime", 12.5), NEPH_OK);
  assert_int_equal(np_image_set_integer(image, "nephos:samples", -7), NEPH_OK);
  assert_string_equal(neph_image_get_attribute(image, "nephos:isa"), "x86-64-v3");
  assert_string_equal(neph_image_get_attribute(image, "renderTime"), "12.5");
  assert_string_equal(neph_image_get_attribute(image, "nephos:samples"), "-7");
  assert_int_equal(neph_image_set_attribute(image, "", "x"), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "attribute name");
  neph_image_destroy(image);
}

/* ---- Round trips ---- */

static void floats_return_with_their_bits(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  image->channels[0].values[5] = NAN;
  image->channels[1].values[6] = -0.0f;
  image->channels[2].values[7] = 1e-42f; /* subnormal, on threads that flush such */
  image->channels[3].values[8] = 3e38f;
  image->channels[4].values[9] = INFINITY;
  save(f, image, NEPH_PIXEL_FLOAT);
  neph_image *loaded = load(f);
  assert_int_equal(loaded->channel_count, RGBAZ_COUNT);
  for (unsigned c = 0; c < RGBAZ_COUNT; c++)
    assert_memory_equal(neph_image_get_channel(loaded, rgbaz[c]), image->channels[c].values,
                        WIDTH * HEIGHT * sizeof(float));
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 1);
  assert_non_null(strstr(f->log.text, "channel R holds 1 NaN, the first at pixel (5, 0)"));
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

static void halves_are_rounded_to_nearest_and_depth_stays_float(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  const float corners[] = {65504.0f, 65519.0f, -65504.0f, 0x1p-24f,      0x1.8p-25f,
                           0x1p-25f, 1e-30f,   -0.0f,     1.00048828125f};
  memcpy(image->channels[0].values, corners, sizeof corners);
  image->channels[4].values[0] = 1e30f;
  image->channels[4].values[1] = INFINITY;
  save(f, image, NEPH_PIXEL_HALF);
  neph_image *loaded = load(f);
  for (unsigned c = 0; c < RGBAZ_COUNT; c++)
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
      float value = image->channels[c].values[i];
      float expected = c == 4 ? value : np_half_to_float(np_half_from_float(value));
      assert_int_equal(get_bits(neph_image_get_channel(loaded, rgbaz[c])[i]), get_bits(expected));
    }
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

static void fill_header(np_image_header *header) {
  for (int i = 0; i < 16; i++) {
    header->world_to_camera[i] = (float)i;
    header->world_to_ndc[i] = (float)-i;
  }
  for (int i = 0; i < 8; i++) header->chromaticities[i] = 0.125f * (float)i;
  header->has_camera = header->has_ndc = header->is_latlong = header->has_chromaticities = header->has_window = true;
  const int min[2] = {100, 200}, max[2] = {100 + WIDTH - 1, 200 + HEIGHT - 1}, display_max[2] = {959, 539};
  memcpy(header->data_min, min, sizeof min);
  memcpy(header->data_max, max, sizeof max);
  memcpy(header->display_max, display_max, sizeof display_max);
}

static const char long_name[] = "nephos:a_name_that_is_longer_than_thirty_one_bytes";

static neph_image *create_picture_with_header(neph_context *context) {
  neph_image *image = create_picture(context);
  fill_header(&image->header);
  assert_int_equal(neph_image_set_attribute(image, "nephos:integrator", "march"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, "comments", "ein Wölkchen"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, long_name, ""), NEPH_OK);
  assert_int_equal(np_image_set_real(image, "nephos:scale", 0.25), NEPH_OK);
  assert_int_equal(np_image_set_integer(image, "nephos:samples", 64), NEPH_OK);
  return image;
}

static void headers_return(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture_with_header(f->context);
  save(f, image, NEPH_PIXEL_HALF);
  neph_image *loaded = load(f);
  assert_memory_equal(&loaded->header, &image->header, sizeof image->header);
  assert_string_equal(neph_image_get_attribute(loaded, "nephos:integrator"), "march");
  assert_string_equal(neph_image_get_attribute(loaded, "comments"), "ein Wölkchen");
  assert_string_equal(neph_image_get_attribute(loaded, long_name), "");
  assert_string_equal(neph_image_get_attribute(loaded, "nephos:scale"), "0.25");
  assert_int_equal(np_image_search_attribute(loaded, "nephos:scale")->type, NP_IMAGE_REAL);
  assert_int_equal(np_image_search_attribute(loaded, "nephos:samples")->type, NP_IMAGE_INTEGER);
  char software[64];
  snprintf(software, sizeof software, "nephos %s", neph_version_get_text());
  assert_string_equal(neph_image_get_attribute(loaded, "software"), software);
  assert_memory_equal(neph_image_get_channel(loaded, "Z"), neph_image_get_channel(image, "Z"),
                      WIDTH * HEIGHT * sizeof(float));
  save(f, loaded, NEPH_PIXEL_HALF); /* and once more, as a picture that came from a file */
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

static void pixels_do_not_depend_on_the_number_of_threads(void **state) {
  test_fixture *f = *state;
  void *bytes[2];
  size_t sizes[2];
  for (unsigned threads = 1; threads <= 2; threads++) {
    neph_context *context = test_context_create(threads * 2 - 1, &f->log);
    neph_image *image = create_picture(context);
    save(f, image, NEPH_PIXEL_HALF);
    neph_image_destroy(image);
    neph_context_destroy(context);
    FILE *file = fopen(f->path, "rb");
    bytes[threads - 1] = calloc(1, 1 << 20);
    sizes[threads - 1] = fread(bytes[threads - 1], 1, 1 << 20, file);
    fclose(file);
  }
  assert_int_equal(sizes[0], sizes[1]);
  assert_memory_equal(bytes[0], bytes[1], sizes[0]);
  free(bytes[0]);
  free(bytes[1]);
}

static void descriptions_hold_what_the_file_holds(void **state) {
  test_fixture *f = *state;
  char *text;
  neph_image *image = create_picture_with_header(f->context);
  save(f, image, NEPH_PIXEL_HALF);
  neph_image_destroy(image);
  const char *const plain[] = {"45 x 37 pixels", "ZIP compression",          "R (half)",
                               "Z (float)",      "(100, 200) to (144, 236)", "nephos:integrator       march",
                               "worldToNDC"};
  assert_int_equal(neph_image_describe_file(f->context, f->path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  for (size_t i = 0; i < sizeof plain / sizeof *plain; i++) assert_non_null(strstr(text, plain[i]));
  neph_text_destroy(f->context, text);
  const char *const json[] = {"\"width\": 45",          "\"compression\": \"ZIP\"",         "\"nephos:samples\": 64",
                              "\"nephos:scale\": 0.25", "\"nephos:integrator\": \"march\"", "\"worldToCamera\""};
  assert_int_equal(neph_image_describe_file(f->context, f->path, NEPH_TEXT_JSON, &text), NEPH_OK);
  for (size_t i = 0; i < sizeof json / sizeof *json; i++) assert_non_null(strstr(text, json[i]));
  neph_text_destroy(f->context, text);
}

/* ---- Values that may not be written ---- */

/* A picture requested in halves is saved in floats, bit by bit. */
static void assert_saved_as_float(test_fixture *f, const neph_image *image) {
  save(f, image, NEPH_PIXEL_HALF);
  neph_image *loaded = load(f);
  for (unsigned c = 0; c < RGBAZ_COUNT; c++) {
    assert_string_equal(loaded->channels[c].stored, "float");
    assert_memory_equal(neph_image_get_channel(loaded, rgbaz[c]), image->channels[c].values,
                        WIDTH * HEIGHT * sizeof(float));
  }
  neph_image_destroy(loaded);
}

static void overflowing_half_is_float_and_names_pixel_value_and_scale(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  image->channels[1].values[2 * WIDTH + 7] = 70000.0f;
  image->channels[5].values[3 * WIDTH + 9] = -300000.0f;
  assert_saved_as_float(f, image);
  /* 300000/2³ = 37500 fits, 300000/2² does not. */
  assert_one_warning(&f->log, f->path, "written as float", "pixel (9, 3)", "channel sun.R", "-300000",
                     "output.scale to 0.125", "it is 1");
  assert_int_equal(np_image_set_real(image, "nephos:scale", 4.0), NEPH_OK);
  assert_saved_as_float(f, image);
  assert_one_warning(&f->log, "output.scale to 0.5", "it is 4");
  save(f, image, NEPH_PIXEL_FLOAT);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  neph_image_destroy(image);
}

/* A finished picture is never discarded. */
static void infinite_colours_are_written_with_a_warning(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context), *read;
  image->channels[2].values[WIDTH] = INFINITY;
  for (int type = NEPH_PIXEL_HALF; type <= NEPH_PIXEL_FLOAT; type++) {
    assert_int_equal(neph_image_save_exr(image, f->path, (neph_pixel_type)type), NEPH_OK);
    assert_one_warning(&f->log, "pixel (0, 1)", "channel B", "1 infinite values");
    assert_int_equal(neph_image_load_exr(f->context, f->path, &read), NEPH_OK);
    assert_true(isinf(neph_image_get_channel(read, "B")[WIDTH]));
    neph_image_destroy(read);
  }
  neph_image_destroy(image);
}

static void scale_picture(neph_image *image, float factor) {
  for (unsigned c = 0; c < 3; c++)
    for (int i = 0; i < WIDTH * HEIGHT; i++) image->channels[c].values[i] *= factor;
}

/* The picture's values lie in [1e-3, 10], their brightest channel's median near 1. */
static void crushing_half_is_float_and_names_a_scale_that_works(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  scale_picture(image, 1e-7f);
  save(f, image, NEPH_PIXEL_HALF); /* not said to be radiances */
  assert_int_equal(np_image_set_real(image, "nephos:scale", 2.0), NEPH_OK);
  assert_saved_as_float(f, image);
  const char *said = strstr(f->log.text, "output.scale to ");
  assert_non_null(said);
  double scale = strtod(said + strlen("output.scale to "), NULL);
  int exponent;
  assert_true(frexp(scale, &exponent) == 0.5);
  assert_one_warning(&f->log, f->path, "written as float", "2^-14", "it is 2");
  scale_picture(image, (float)(scale / 2.0));
  assert_int_equal(np_image_set_real(image, "nephos:scale", scale), NEPH_OK);
  save(f, image, NEPH_PIXEL_HALF);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  neph_image *loaded = load(f);
  assert_string_equal(loaded->channels[0].stored, "half");
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* The brighter half may be as bright as it likes: one pixel more below 2⁻¹⁴ than not, and the picture is float. */
static void half_the_lit_pixels_may_be_dark(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  enum { LIT = 600 };
  assert_int_equal(np_image_set_real(image, "nephos:scale", 1.0), NEPH_OK);
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    for (unsigned c = 0; c < 3; c++) image->channels[c].values[i] = i < LIT / 2 ? 0x1p-15f : i < LIT ? 1.0f : 0.0f;
  save(f, image, NEPH_PIXEL_HALF);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  for (unsigned c = 0; c < 3; c++) image->channels[c].values[LIT / 2] = 0x1p-15f;
  assert_saved_as_float(f, image);
  assert_one_warning(&f->log, "more than half of the lit pixels");
  neph_image_destroy(image);
}

static void picture_too_deep_for_any_half_is_told_to_be_float(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  scale_picture(image, 1e-7f);
  image->channels[0].values[0] = 60000.0f;
  assert_int_equal(np_image_set_real(image, "nephos:scale", 1.0), NEPH_OK);
  assert_saved_as_float(f, image);
  assert_one_warning(&f->log, "no scale fits", "pixel_type to float", "60000");
  memset(image->channels[0].values, 0, WIDTH * HEIGHT * sizeof(float));
  memset(image->channels[1].values, 0, WIDTH * HEIGHT * sizeof(float));
  memset(image->channels[2].values, 0, WIDTH * HEIGHT * sizeof(float));
  save(f, image, NEPH_PIXEL_HALF); /* black has no lit pixel to lose */
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  neph_image_destroy(image);
}

/* ---- Places that cannot be written ---- */

static void missing_folder_is_an_error(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  char *path = test_path(f->folder, "no/such/picture.exr");
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_HALF), NEPH_ERROR_IO);
  assert_one_error(&f->log, path, "No such file or directory");
  assert_int_equal(test_folder_count(f->folder), 0);
  neph_image_destroy(image);
  free(path);
}

static neph_result save_float(const char *path, const void *image) {
  return neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT);
}

/* A header alone is about 700 bytes. */
static void full_disk_leaves_nothing(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  assert_survives_full_disk(f, 8000, 400, save_float, image);
  neph_image_destroy(image);
}

static void failed_write_leaves_the_old_picture(void **state) {
  test_fixture *f = *state;
  neph_image *image = create_picture(f->context);
  save(f, image, NEPH_PIXEL_HALF);
  assert_survives_full_disk(f, 8000, 4000, save_float, image);
  neph_image *loaded = load(f);
  assert_int_equal(test_folder_count(f->folder), 1);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
}

/* ---- Files that cannot be read ---- */

static void missing_file_is_not_found(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  char *text;
  assert_int_equal(neph_image_load_exr(f->context, f->path, &image), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, f->path, "No such file");
  assert_int_equal(neph_image_describe_file(f->context, f->path, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, f->path);
  assert_int_equal(neph_image_load_exr(f->context, f->folder, &image), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "it is a folder");
}

static test_file make_valid_file(test_fixture *f) {
  neph_image *image = create_picture_with_header(f->context);
  save(f, image, NEPH_PIXEL_HALF);
  neph_image_destroy(image);
  return test_file_read(f->path);
}

/* The decoder itself, in this process, where a sanitizer sees it. */
static neph_result decode(neph_context *context, const char *path, neph_image **out_image) {
  return np_image_decode_exr(context, open(path, O_RDONLY | O_CLOEXEC), path, out_image);
}

/* Every prefix of the header, and a step of 61 bytes through the pixels. */
static void every_prefix_of_a_file_is_an_error(void **state) {
  test_fixture *f = *state;
  test_file file = make_valid_file(f);
  for (size_t size = 0; size < file.size; size += size < 1500 ? 1 : 61) {
    neph_image *image;
    test_file_write(f->path, file.bytes, size);
    assert_int_equal(decode(f->context, f->path, &image), NEPH_ERROR_BAD_FILE);
    assert_null(image);
    assert_one_error(&f->log, f->path, "damaged, cut short");
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
  const neph_result result = neph_image_load_exr(context, path, &image);
  neph_image_destroy(image);
  return result;
}

/* Half of them in the header and the first chunk. */
static void flipped_bytes_are_survived(void **state) {
  test_fixture *f = *state;
  free(make_valid_file(f).bytes);
  assert_survives_changed_bytes(f, SIZE_MAX, 1000, decode_and_destroy);
  assert_survives_changed_bytes(f, 1500, 1000, decode_and_destroy);
  assert_survives_changed_bytes(f, 1500, 50, load_and_destroy);
}

static uint8_t *search_bytes(test_file file, const char *text) {
  uint8_t *found = memmem(file.bytes, file.size, text, strlen(text));
  assert_non_null(found);
  return found;
}

static void put_int(uint8_t *at, int32_t value) { memcpy(at, &value, sizeof value); }

/* Behind the attribute's name, its type and its size stand xMin, yMin, xMax, yMax. */
static void huge_claims_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  const int32_t claims[][4] = {
      {0, 0, 1 << 20, 1 << 20}, {INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX}, {0, 0, 65535, 65535}, {5, 5, 4, 4}};
  test_file file = make_valid_file(f);
  uint8_t *window = search_bytes(file, "dataWindow") + sizeof "dataWindow" + sizeof "box2i" + 4;
  for (size_t i = 0; i < sizeof claims / sizeof *claims; i++) {
    for (int k = 0; k < 4; k++) put_int(window + 4 * k, claims[i][k]);
    test_file_write(f->path, file.bytes, file.size);
    assert_int_equal(neph_image_load_exr(f->context, f->path, &image), NEPH_ERROR_BAD_FILE);
    if (i == 0) assert_non_null(strstr(f->log.text, "1 to 65536 each way"));
    assert_one_error(&f->log, f->path);
  }
  free(file.bytes);
}

/* The first channel's samplings are the last two numbers of its entry: name, type, linear, three reserved. */
static void sub_sampled_channels_are_refused(void **state) {
  test_fixture *f = *state;
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, 4, 4, RGBAZ_COUNT, rgbaz, &image), NEPH_OK);
  save(f, image, NEPH_PIXEL_HALF);
  neph_image_destroy(image);
  test_file file = test_file_read(f->path);
  uint8_t *channel = search_bytes(file, "chlist") + sizeof "chlist" + 4;
  put_int(channel + sizeof "A" + 8, 2);
  test_file_write(f->path, file.bytes, file.size);
  assert_int_equal(neph_image_load_exr(f->context, f->path, &image), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "channel A", "sub-sampled 2 × 1");
  free(file.bytes);
}

/* ---- Memory ---- */

static neph_result save_and_load(neph_context *context, void *user) {
  neph_image *image = NULL, *loaded = NULL;
  const char *path = user, *const names[] = {"R", "Z"};
  char *text = NULL;
  neph_result result = neph_image_create(context, 8, 40, 2, names, &image);
  if (!result) result = neph_image_set_attribute(image, "nephos:isa", "x86-64");
  if (!result) result = np_image_set_real(image, "renderTime", 3.0);
  if (!result) result = neph_image_save_exr(image, path, NEPH_PIXEL_HALF);
  if (!result) result = neph_image_load_exr(context, path, &loaded);
  if (!result) result = neph_image_describe_file(context, path, NEPH_TEXT_PLAIN, &text);
  neph_text_destroy(context, text);
  neph_image_destroy(loaded);
  neph_image_destroy(image);
  return result;
}

static void failed_allocations_are_survived(void **state) {
  test_fixture *f = *state;
  assert_survives_failed_allocations(save_and_load, f->path);
  assert_int_equal(test_folder_count(f->folder), 1);
}

#define EXR_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      EXR_TEST(images_begin_black_and_know_their_channels),
      EXR_TEST(impossible_images_are_refused),
      EXR_TEST(attributes_are_set_and_replaced),
      EXR_TEST(floats_return_with_their_bits),
      EXR_TEST(halves_are_rounded_to_nearest_and_depth_stays_float),
      EXR_TEST(headers_return),
      EXR_TEST(pixels_do_not_depend_on_the_number_of_threads),
      EXR_TEST(descriptions_hold_what_the_file_holds),
      EXR_TEST(overflowing_half_is_float_and_names_pixel_value_and_scale),
      EXR_TEST(infinite_colours_are_written_with_a_warning),
      EXR_TEST(crushing_half_is_float_and_names_a_scale_that_works),
      EXR_TEST(half_the_lit_pixels_may_be_dark),
      EXR_TEST(picture_too_deep_for_any_half_is_told_to_be_float),
      EXR_TEST(missing_folder_is_an_error),
      EXR_TEST(full_disk_leaves_nothing),
      EXR_TEST(failed_write_leaves_the_old_picture),
      EXR_TEST(missing_file_is_not_found),
      EXR_TEST(every_prefix_of_a_file_is_an_error),
      EXR_TEST(flipped_bytes_are_survived),
      EXR_TEST(huge_claims_are_refused),
      EXR_TEST(sub_sampled_channels_are_refused),
      EXR_TEST(failed_allocations_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
