/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include <jansson.h>
#include <png.h>

#include <nephos/image.h>

#include "core/alloc.h"
#include "core/units.h"
#include "terrain/heightfield.h"

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

static neph_result load(test_fixture *f, const char *path, np_heightfield *out) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  return np_heightfield_load(f->context, NULL, path, &desc, out);
}

static float get_sample(const np_heightfield *field, unsigned column, unsigned row) {
  return field->elevation_m[(size_t)row * field->width + column];
}

/* ---- Real tiles: figures of shared data's own description ---- */

static void mount_washington_is_read(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("dem/N44W072.hgt");
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_int_equal(field.width, 1201);
  assert_int_equal(field.height, 1201);
  assert_true(field.has_place);
  assert_near(field.south_rad, 44 * NP_DEGREE, 1e-15);
  assert_near(field.west_rad, -72 * NP_DEGREE, 1e-15);
  assert_near(field.step_north_rad * 1200, NP_DEGREE, 1e-15);
  assert_true(field.elevation_min_m == 115.0f && field.elevation_max_m == 1908.0f);
  assert_int_equal(field.void_count, 0);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void voids_of_an_island_are_filled_and_counted(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("dem/N22W160.hgt");
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_int_equal(field.void_count, 4279);
  assert_true(field.elevation_min_m < 0);
  for (size_t i = 0; i < (size_t)field.width * field.height; i++) {
    assert_true(field.elevation_m[i] >= field.elevation_min_m);
    assert_true(field.elevation_m[i] <= field.elevation_max_m);
  }
  np_heightfield_destroy(f->context, &field);
  free(path);
}

/* ---- Synthetic tiles ---- */

static int encode_place(unsigned column, unsigned row) { return (int)(column + 2 * row) - 1500; }
static int be_void(unsigned column, unsigned row) { return (void)column, (void)row, -32768; }
static int slope_with_hole(unsigned column, unsigned row) {
  return column >= 500 && column < 560 && row >= 700 && row < 750 ? -32768 : (int)column;
}

/* The file's first row is the field's last; names are read in either case and on either side of the equator. */
static void samples_and_corner_are_where_they_belong(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "s07e106.HGT", 1201, encode_place);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_near(field.south_rad, -7 * NP_DEGREE, 1e-15);
  assert_near(field.west_rad, 106 * NP_DEGREE, 1e-15);
  assert_true(get_sample(&field, 0, 1200) == -1500.0f);
  assert_true(get_sample(&field, 17, 1200) == -1483.0f);
  assert_true(get_sample(&field, 0, 0) == 900.0f);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void one_arc_second_tiles_are_read(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N00E000.SRTMGL1.hgt", 3601, encode_place);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_int_equal(field.width, 3601);
  assert_near(field.step_east_rad * 3600, NP_DEGREE, 1e-15);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

/* A hole of 60 columns in a slope of 1 m per column. Push-pull flattens within a hole: by at most half of its width
 * would be a constant fill; a fifth of it shows that the slope goes on across. */
static void a_hole_takes_the_heights_around_it(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 1201, slope_with_hole);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_int_equal(field.void_count, 60 * 50);
  for (unsigned row = 0; row < 1201; row++)
    for (unsigned column = 0; column < 1201; column++)
      assert_near((double)get_sample(&field, column, row), column,
                  slope_with_hole(column, 1200 - row) < 0 ? 12.0 : 0.0);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void a_tile_of_voids_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 1201, be_void);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "N10E010.hgt", "none of its 1442401 samples");
  assert_null(field.elevation_m);
  free(path);
}

static void a_truncated_tile_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 1201, encode_place);
  assert_int_equal(truncate(path, 1000001), 0);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "N10E010.hgt", "1000001 bytes", "2884802", "25934402");
  free(path);
}

/* A version, a product, a note: whatever a distributor puts there. */
static void names_go_on_after_the_corner(void **state) {
  test_fixture *f = *state;
  const char *names[] = {"S16E166v2.3a.hgt", "s16e166_void-filled.hgt", "S16E166-1.hgt", "S16E166.SRTMGL3.hgt"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char *path = test_hgt_write(f->folder, names[i], 1201, encode_place);
    np_heightfield field;
    assert_int_equal(load(f, path, &field), NEPH_OK);
    assert_near(field.south_rad, -16 * NP_DEGREE, 1e-15);
    assert_near(field.west_rad, 166 * NP_DEGREE, 1e-15);
    np_heightfield_destroy(f->context, &field);
    free(path);
  }
}

static void tiles_without_a_corner_are_refused(void **state) {
  test_fixture *f = *state;
  const char *names[] = {"mountain.hgt", "X44W072.hgt", "N44W07.hgt",   "N4xW072.hgt",
                         "N91E000.hgt",  "N44W181.hgt", "N44W0721.hgt", ".hgt"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char *path = test_hgt_write(f->folder, names[i], 2, encode_place);
    np_heightfield field;
    assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, names[i], "N44W072.hgt");
    free(path);
  }
}

static void other_files_are_refused(void **state) {
  test_fixture *f = *state;
  np_heightfield field;
  char *missing = test_path(f->folder, "N01E001.hgt");
  assert_int_equal(load(f, missing, &field), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, missing);
  char *jpg = test_hgt_write(f->folder, "N01E001.jpg", 2, encode_place);
  assert_int_equal(load(f, jpg, &field), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, jpg, ".hgt, .hgt.zip, .tif", "\".jpg\"");
  free(missing);
  free(jpg);
}

/* ---- Pictures ---- */

static char *write_exr(test_fixture *f, const char *name, unsigned width, unsigned height, const char *channel,
                       float (*value)(unsigned x, unsigned y)) {
  neph_image *image = NULL;
  char *path = test_path(f->folder, name);
  assert_int_equal(neph_image_create(f->context, width, height, 1, &channel, &image), NEPH_OK);
  float *values = neph_image_get_channel(image, channel);
  for (unsigned y = 0; y < height; y++)
    for (unsigned x = 0; x < width; x++) values[y * width + x] = value(x, y);
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  return path;
}

static float picture_value(unsigned x, unsigned y) { return 0.25f * (float)x - 10.5f * (float)y; }
static float picture_with_gaps(unsigned x, unsigned y) {
  return x == 2 && y == 1 ? NAN : x == 3 && y == 3 ? -INFINITY : 700.0f;
}
static float absurd_value(unsigned x, unsigned y) { return x == 3 && y == 1 ? 2e5f : 0; }

static void exr_is_in_metres(void **state) {
  test_fixture *f = *state;
  const char *channels[] = {"Y", "Z", "height"};
  for (int i = 0; i < 3; i++) {
    char *path = write_exr(f, "heights.exr", 9, 5, channels[i], picture_value);
    np_heightfield field;
    assert_int_equal(load(f, path, &field), NEPH_OK);
    assert_int_equal(field.width, 9);
    assert_int_equal(field.height, 5);
    assert_false(field.has_place);
    for (unsigned y = 0; y < 5; y++)
      for (unsigned x = 0; x < 9; x++) assert_true(get_sample(&field, x, 4 - y) == picture_value(x, y));
    /* 30 km wide on a sphere of 6360 km, steps alike both ways, centred. */
    assert_near(field.step_east_rad * 8, 30.0 / 6360.0, 1e-15);
    assert_near(field.step_north_rad, field.step_east_rad, 0);
    assert_near(field.south_rad, -2 * field.step_north_rad, 1e-18);
    np_heightfield_destroy(f->context, &field);
    free(path);
  }
}

/* In Z, where a picture may hold infinities. */
static void values_that_are_no_numbers_are_voids(void **state) {
  test_fixture *f = *state;
  char *path = write_exr(f, "gaps.exr", 8, 8, "Z", picture_with_gaps);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_OK);
  assert_int_equal(field.void_count, 2);
  for (unsigned i = 0; i < 64; i++) assert_true(field.elevation_m[i] == 700.0f);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void absurd_elevations_are_refused(void **state) {
  test_fixture *f = *state;
  char *path = write_exr(f, "absurd.exr", 8, 8, "Y", absurd_value);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "absurd.exr", "200000", "column 3, row 1", "100 km");
  free(path);
}

static void a_picture_of_one_row_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = write_exr(f, "row.exr", 8, 1, "Y", picture_value);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "row.exr", "8 × 1", "2 to 16385");
  free(path);
}

/* A width that fits the planet but a height that goes round it. */
static void a_picture_larger_than_the_planet_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = write_exr(f, "tall.exr", 2, 300, "Y", picture_value);
  np_heightfield field;
  assert_int_equal(load(f, path, &field), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "km", "planet");
  free(path);
}

/* Value 0 stands for height_min, 65535 for height_max; the northern row is on top. */
static void png_is_scaled_to_its_range(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "heights.png");
  const png_uint_16 values[2 * 3] = {0, 65535, 13107, 52428, 1, 65534};
  png_image picture = {.version = PNG_IMAGE_VERSION, .width = 3, .height = 2, .format = PNG_FORMAT_LINEAR_Y};
  assert_true(png_image_write_to_file(&picture, path, 0, values, 0, NULL));
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.height_min_m = -100;
  desc.height_max_m = 900;
  np_heightfield field;
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_OK);
  for (unsigned i = 0; i < 6; i++) /* float of 24 bits at 900 m */
    assert_near((double)get_sample(&field, i % 3, 1 - i / 3), -100 + 1000 * values[i] / 65535.0, 1e-4);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void write_png(const char *path, unsigned format, const void *values, const void *colors) {
  png_image picture = {
      .version = PNG_IMAGE_VERSION, .width = 2, .height = 2, .format = format, .colormap_entries = colors ? 2 : 0};
  assert_true(png_image_write_to_file(&picture, path, 0, values, 0, colors));
}

/* Refused by its header before a render, and by loading it. */
static void assert_refused(test_fixture *f, const char *path, const char *complaint, const char *remedy) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  unsigned size[2];
  assert_int_equal(load(f, path, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, complaint, remedy);
  assert_null(field.elevation_m);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, complaint, remedy);
}

static void png_of_anything_but_16_bit_grey_is_refused(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "picture.png");
  const uint8_t bytes[12] = {0, 1, 1, 0}, colors[6] = {0, 0, 0, 255, 128, 0};
  const png_uint_16 words[12] = {0, 65535};
  write_png(path, PNG_FORMAT_GRAY, bytes, NULL);
  assert_refused(f, path, "8-bit samples", "16-bit grey");
  write_png(path, PNG_FORMAT_RGB, bytes, NULL);
  assert_refused(f, path, "8-bit samples", "16-bit grey");
  write_png(path, PNG_FORMAT_RGB_COLORMAP, bytes, colors);
  assert_refused(f, path, "palette samples", "16-bit grey");
  write_png(path, PNG_FORMAT_LINEAR_RGB, words, NULL);
  assert_refused(f, path, "3 channels (R, G, B)", "must hold one");
  free(path);
}

/* Alpha beside grey, and depth beside alpha, leave no doubt which channel is of heights. */
static void exr_of_several_channels_is_refused(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *channels[5];
    const char *complaint; /* NULL: it is read */
  } cases[] = {{{"Y", "A"}, NULL},
               {{"A", "Z"}, NULL},
               {{"A", "height"}, "2 channels (A, height)"},
               {{"R", "G", "B"}, "3 channels (B, G, R)"},
               {{"R", "G", "B", "A", "Z"}, "5 channels (A, B, G, …)"}};
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *path = test_path(f->folder, "picture.exr");
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    unsigned count = 0, size[2];
    neph_image *image = NULL;
    np_heightfield field;
    while (count < 5 && cases[i].channels[count]) count++;
    assert_int_equal(neph_image_create(f->context, 3, 2, count, cases[i].channels, &image), NEPH_OK);
    assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
    neph_image_destroy(image);
    if (cases[i].complaint) {
      assert_refused(f, path, cases[i].complaint, "must hold one");
      continue;
    }
    assert_int_equal(load(f, path, &field), NEPH_OK);
    assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_OK);
    assert_true(size[0] == 3 && size[1] == 2);
    np_heightfield_destroy(f->context, &field);
  }
  free(path);
}

/* ---- Descriptions ---- */

static void a_tile_describes_itself(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 1201, slope_with_hole), *text = NULL;
  assert_int_equal(neph_terrain_describe_file(f->context, path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_string_equal(text, "samples     1201 x 1201\n"
                            "elevation   0 to 1200 m\n"
                            "voids       3000\n"
                            "center      10.5, 10.5 deg (latitude, longitude)\n"
                            "spacing     3 arc seconds\n");
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_terrain_describe_file(f->context, path, NEPH_TEXT_JSON, &text), NEPH_OK);
  json_t *json = json_loads(text, 0, NULL);
  assert_int_equal(json_integer_value(json_object_get(json, "void_count")), 3000);
  assert_near(json_real_value(json_object_get(json, "center_latitude_deg")), 10.5, 1e-12);
  assert_string_equal(json_string_value(json_object_get(json, "elevation_unit")), "m");
  json_decref(json);
  neph_text_destroy(f->context, text);
  free(path);
}

static void a_broken_file_has_no_description(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 3, encode_place), *text = f->folder;
  assert_int_equal(neph_terrain_describe_file(f->context, path, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_BAD_FILE);
  assert_null(text);
  assert_one_error(&f->log, "18 bytes");
  free(path);
}

/* ---- The globe ---- */

/* Points on the sphere 30 km away lie r²/2R below the tangent plane: 70.75 m (the next term is 0.4 mm). */
static void the_world_curves_away(void **state) {
  (void)state;
  const np_globe globe = np_globe_make(6360e3, 0.7, -1.2);
  const np_dvec3 north = np_globe_to_world(&globe, 0.7 + 30e3 / 6360e3, -1.2, 0);
  assert_near(north.z, -30e3 * 30e3 / (2 * 6360e3), 1e-3);
  assert_near(north.x, 0, 1e-8);
  assert_true(north.y > 29999 && north.y < 30000);
  const np_dvec3 east = np_globe_to_world(&globe, 0.7, -1.2 + 30e3 / (6360e3 * cos(0.7)), 0);
  assert_true(east.x > 29999 && east.x < 30000);
  assert_near(np_altitude(np_globe_to_world(&globe, 0.69, -1.21, 1234.5), 6360e3), 1234.5, 1e-6);
}

/* Maps a world point back to its sample: 1e-6 of a sample is 0.1 mm. Works across the date line too. */
static void locating_undoes_raising(void **state) {
  test_fixture *f = *state;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  assert_int_equal(np_heightfield_create_flat(f->context, 301, 201, &desc, &field), NEPH_OK);
  field.west_rad = 3.14;
  field.south_rad = 0.9;
  for (size_t i = 0; i < 301 * 201; i++) field.elevation_m[i] = (float)(i % 301) * 10.0f - 500.0f;
  const np_globe globe = np_globe_make(6360e3, 0.9, -3.14);
  for (unsigned row = 1; row < 200; row += 6)
    for (unsigned column = 1; column < 300; column += 7) {
      const np_dvec3 point =
          np_globe_to_world(&globe, 0.9 + row * field.step_north_rad, 3.14 + column * field.step_east_rad,
                            (double)field.elevation_m[(size_t)row * 301 + column]);
      np_field_position position;
      assert_true(np_heightfield_locate(&field, &globe, point.x, point.y, &position));
      assert_near(position.column, column, 1e-6);
      assert_near(position.row, row, 1e-6);
    }
  np_field_position position;
  assert_false(np_heightfield_locate(&field, &globe, -1e6, 0, &position));
  assert_false(np_heightfield_locate(&field, &globe, 6.5e6, 0, &position));
  np_heightfield_destroy(f->context, &field);
}

/* ---- Ridges ---- */

static void make_ridges(neph_context *context, const neph_ridges_desc *ridges, np_heightfield *out) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_heightfield_make_ridges(context, &monitor, ridges, &desc, out), NEPH_OK);
}

static void ridges_span_their_relief(void **state) {
  test_fixture *f = *state;
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 129;
  np_heightfield field;
  make_ridges(f->context, &ridges, &field);
  float low = INFINITY, high = -INFINITY;
  for (size_t i = 0; i < 129 * 129; i++) {
    low = fminf(low, field.elevation_m[i]);
    high = fmaxf(high, field.elevation_m[i]);
  }
  assert_true(low == 0.0f);
  assert_near((double)high, 1400.0, 1e-3); /* scaled by one float division and one product */
  np_heightfield_destroy(f->context, &field);
}

/* The same bits for one thread and two, and at every instruction-set level; other seeds give other mountains. */
static void ridges_depend_on_their_seed_alone(void **state) {
  test_fixture *f = *state;
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 300;
  const size_t bytes = 300 * 300 * sizeof(float);
  np_heightfield field, other;
  make_ridges(f->context, &ridges, &field);
  for (int level = NEPH_ISA_X86_64; level <= NEPH_ISA_X86_64_V4; level++) {
    neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
    desc.thread_count = 1;
    desc.isa_max = (neph_isa)level;
    neph_context *context = NULL;
    assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
    make_ridges(context, &ridges, &other);
    assert_memory_equal(field.elevation_m, other.elevation_m, bytes);
    np_heightfield_destroy(context, &other);
    neph_context_destroy(context);
  }
  ridges.seed = 2;
  make_ridges(f->context, &ridges, &other);
  assert_true(memcmp(field.elevation_m, other.elevation_m, bytes) != 0);
  np_heightfield_destroy(f->context, &other);
  np_heightfield_destroy(f->context, &field);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)
  const struct CMUnitTest tests[] = {
      TEST(mount_washington_is_read),
      TEST(voids_of_an_island_are_filled_and_counted),
      TEST(samples_and_corner_are_where_they_belong),
      TEST(one_arc_second_tiles_are_read),
      TEST(a_hole_takes_the_heights_around_it),
      TEST(a_tile_of_voids_is_refused),
      TEST(a_truncated_tile_is_refused),
      TEST(names_go_on_after_the_corner),
      TEST(tiles_without_a_corner_are_refused),
      TEST(other_files_are_refused),
      TEST(exr_is_in_metres),
      TEST(values_that_are_no_numbers_are_voids),
      TEST(absurd_elevations_are_refused),
      TEST(a_picture_of_one_row_is_refused),
      TEST(a_picture_larger_than_the_planet_is_refused),
      TEST(png_is_scaled_to_its_range),
      TEST(png_of_anything_but_16_bit_grey_is_refused),
      TEST(exr_of_several_channels_is_refused),
      TEST(a_tile_describes_itself),
      TEST(a_broken_file_has_no_description),
      TEST(the_world_curves_away),
      TEST(locating_undoes_raising),
      TEST(ridges_span_their_relief),
      TEST(ridges_depend_on_their_seed_alone),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
