/* SPDX-License-Identifier: Apache-2.0 */
/* Ground beyond the border of a height field; samples without a header, and samples encoded in colours. */
#include "test_terrains.h"

#include <png.h>
#include <string.h>

#include "terrain/terrain_surroundings.h"

/* ---- Edges ---- */

static int stand_high(unsigned column, unsigned row) { return (void)column, (void)row, 800; }

/* Mountains whose border is none: 300 m to 1300 m, 24 samples from valley to valley. */
static int stand_in_waves(unsigned column, unsigned row) {
  return (int)(800 + 250 * sin(column * 0.26) + 250 * cos(row * 0.31));
}

/* An island in the sea. */
static int rise_in_the_middle(unsigned column, unsigned row) {
  return column > 400 && column < 800 && row > 400 && row < 800 ? 900 : 0;
}

static neph_terrain *make_edge(test_fixture *f, neph_terrain_edge edge, int (*elevation)(unsigned, unsigned)) {
  char *path = test_hgt_write(f->folder, "N44W072.hgt", 1201, elevation);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain = NULL;
  desc.edge = edge;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  free(path);
  return terrain;
}

/* North of the middle of the northern border. */
static const double rim_y_m = 6360e3 * 0.008726535498373935 * (1 - 0.5 * 7.615e-5 / 3);

/* A plateau goes on, and descends less than 1° steep, which is no cliff, to the sphere. */
static void a_plateau_goes_on_to_the_horizon(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_edge(f, NEPH_TERRAIN_EDGE_INFINITE, stand_high);
  double before = 800;
  for (double beyond = -2000; beyond < 260e3; beyond += 250) {
    const double elevation = neph_terrain_get_elevation_m(terrain, 0, rim_y_m + beyond);
    if (beyond < 45e3) assert_near(elevation, 800, 0.1); /* float, and the parallel's bend */
    assert_true(fabs(elevation - before) < 250 * tan(1.0 * NP_DEGREE));
    before = elevation;
  }
  assert_near(neph_terrain_get_elevation_m(terrain, 0, rim_y_m + 249e3), 0, 1);
  assert_false(np_terrain_covers(terrain, 0, rim_y_m + 270e3));
  assert_near(np_terrain_get_elevation_min_m(terrain), 0, 0);
  neph_terrain_release(terrain);
}

/* The relief goes on behind the border, without a step, and calms down. The file's own samples stay. */
static void relief_goes_on_behind_the_border(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_edge(f, NEPH_TERRAIN_EDGE_INFINITE, stand_in_waves);
  const np_heightfield *field = np_terrain_get_field(terrain);
  const unsigned margin = field->margin.count;
  assert_int_equal(np_heightfield_get_core_width(field), 1201);
  for (unsigned row = 0; row < 1201; row += 7)
    for (unsigned column = 0; column < 1201; column += 5)
      assert_true(field->elevation_m[(size_t)(row + margin) * field->width + column + margin] ==
                  (float)stand_in_waves(column, 1200 - row));
  float low = INFINITY, high = -INFINITY;
  for (double x = -20e3; x < 20e3; x += 130) {
    const double inside = neph_terrain_get_elevation_m(terrain, x, rim_y_m - 75);
    const double outside = neph_terrain_get_elevation_m(terrain, x, rim_y_m + 75);
    /* Slopes reach 0.84; ground 1300 m high stands up to 11 m farther out than the sphere below it. */
    assert_true(fabs(inside - outside) < 20);
    const float far = (float)neph_terrain_get_elevation_m(terrain, x, rim_y_m + 40e3);
    low = fminf(low, far);
    high = fmaxf(high, far);
  }
  assert_true(high - low < 60); /* compared with 1000 in the field */
  neph_terrain_release(terrain);
}

static void a_border_at_sea_level_fades(void **state) {
  test_fixture *f = *state;
  neph_terrain *faded = make_edge(f, NEPH_TERRAIN_EDGE_FADE, rise_in_the_middle);
  neph_terrain *endless = make_edge(f, NEPH_TERRAIN_EDGE_INFINITE, rise_in_the_middle);
  const np_heightfield *a = np_terrain_get_field(faded), *b = np_terrain_get_field(endless);
  assert_int_equal(a->width, b->width);
  assert_memory_equal(a->elevation_m, b->elevation_m, (size_t)a->width * a->height * sizeof(float));
  neph_terrain_release(faded);
  neph_terrain_release(endless);
}

/* Elevations are the file's to the last metre; a level ray from outside meets the wall, which looks at it. */
static void a_wall_stands_at_the_border(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_edge(f, NEPH_TERRAIN_EDGE_WALL, stand_high);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, rim_y_m - 1), 800, 1e-3);
  assert_true(neph_terrain_get_elevation_m(terrain, 0, rim_y_m + 20) == 0);
  const double drop_m = rim_y_m * rim_y_m / (2 * radius_m);
  const np_dvec3 origin = np_dvec3_make(0, rim_y_m + 5000, 400 - drop_m);
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, origin, np_vec3_make(0, -1, 0), INFINITY, &hit));
  assert_near(hit.distance, 5000, 20); /* two walls' widths, and the wall's lean by 400 m of height */
  assert_true(hit.facet.y > 0.99f && hit.normal.y > 0.5f);
  /* Its upper end stands farther in than its lower one, seen along the vertical there. */
  assert_true(
      np_vec3_dot(hit.facet, np_zenith(np_dvec3_along(origin, np_vec3_make(0, -1, 0), hit.distance), radius_m)) > 0.0f);
  assert_false(np_terrain_intersect(terrain, origin, np_vec3_make(0, 1, 0), INFINITY, &hit));
  neph_terrain_release(terrain);
}

/* ---- Raw samples ---- */

static char *write_bytes(const test_fixture *f, const char *name, const void *bytes, size_t size) {
  char *path = test_path(f->folder, name);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, size, 1, file), 1);
  assert_int_equal(fclose(file), 0);
  return path;
}

static void assert_corners(test_fixture *f, const char *path, const neph_terrain_desc *desc, double north_west,
                           double south_east) {
  np_heightfield field;
  assert_int_equal(np_heightfield_load(f->context, NULL, path, desc, &field), NEPH_OK);
  assert_int_equal(field.width, 3);
  assert_int_equal(field.height, 2);
  assert_near((double)field.elevation_m[3], north_west, 1e-6 * fabs(north_west));
  assert_near((double)field.elevation_m[2], south_east, 1e-6 * fabs(south_east));
  np_heightfield_destroy(f->context, &field);
}

static void raw_samples_are_read_by_type_and_order(void **state) {
  test_fixture *f = *state;
  const uint8_t words[12] = {0x00, 0x40, 0, 0, 0, 0, 0, 0, 0, 0, 0xfe, 0xff};
  const float floats[6] = {12.25f, 0, 0, 0, 0, -7.5f};
  char *shorts = write_bytes(f, "field.r16", words, sizeof words);
  char *reals = write_bytes(f, "field.raw", floats, sizeof floats);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.raw_size[0] = 3;
  desc.raw_size[1] = 2;
  desc.height_min_m = 100;
  desc.height_max_m = 755.35;
  assert_corners(f, shorts, &desc, 100 + 0.01 * 0x4000, 100 + 0.01 * 0xfffe);
  desc.raw_is_big_endian = true;
  assert_corners(f, shorts, &desc, 100 + 0.01 * 0x0040, 100 + 0.01 * 0xfeff);
  desc.raw_type = NEPH_RAW_TYPE_INT16;
  assert_corners(f, shorts, &desc, 0x0040, -257);
  desc.raw_is_big_endian = false;
  assert_corners(f, shorts, &desc, 0x4000, -2);
  desc.raw_type = NEPH_RAW_TYPE_FLOAT32;
  assert_corners(f, reals, &desc, 12.25, -7.5);
  free(shorts);
  free(reals);
}

static void raw_samples_of_another_size_are_refused(void **state) {
  test_fixture *f = *state;
  const uint8_t words[18] = {0};
  char *path = write_bytes(f, "field.r16", words, sizeof words);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "field.r16", "terrain.raw.size", "[3, 3]");
  desc.raw_size[0] = 3;
  desc.raw_size[1] = 2;
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "has 18 bytes, but 3 × 2 samples of uint16 are 12");
  desc.raw_size[1] = 1;
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "3 × 1, must be 2 to 16385");
  free(path);
}

/* ---- Colours ---- */

static char *write_picture(const test_fixture *f, const char *name, unsigned format, const void *samples) {
  png_image picture = {.version = PNG_IMAGE_VERSION, .width = 3, .height = 2, .format = format};
  char *path = test_path(f->folder, name);
  assert_true(png_image_write_to_file(&picture, path, 0, samples, 0, NULL));
  return path;
}

/* Mapbox's Terrain-RGB v1 and the Terrarium tiles of Tilezen: their own formulas, by hand. */
static void colors_stand_for_heights(void **state) {
  test_fixture *f = *state;
  const uint8_t colors[18] = {1, 134, 160, 1, 134, 160, 1, 134, 160, 1, 134, 160, 1, 134, 160, 2, 3, 4};
  char *path = write_picture(f, "tile.png", PNG_FORMAT_RGB, colors);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.encoding = NEPH_HEIGHT_ENCODING_TERRAIN_RGB;
  assert_corners(f, path, &desc, 0.0, 0.1 * (2 * 65536 + 3 * 256 + 4) - 10000);
  desc.encoding = NEPH_HEIGHT_ENCODING_TERRARIUM;
  assert_corners(f, path, &desc, 256 + 134 + 160 / 256.0 - 32768, 512 + 3 + 4 / 256.0 - 32768);
  free(path);
}

static void colors_that_are_none_are_refused(void **state) {
  test_fixture *f = *state;
  const uint8_t grey[6] = {0};
  const png_uint_16 deep[18] = {0};
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  desc.encoding = NEPH_HEIGHT_ENCODING_TERRARIUM;
  char *path = write_picture(f, "tile.png", PNG_FORMAT_GRAY, grey);
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "tile.png", "8-bit grey samples", "leave the key out");
  free(path);
  path = write_picture(f, "tile.png", PNG_FORMAT_LINEAR_RGB, deep);
  assert_int_equal(np_heightfield_load(f->context, NULL, path, &desc, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "tile.png", "16-bit colour samples");
  free(path);
}

static int make_plateau(unsigned column, unsigned row) { return (void)column, (void)row, 100; }

/* A plateau of one degree that fades over the outer 5 % of its sides: water below its level covers what lies beyond the
 * middle of that border, from where the air has 8 km/√((8 km)² + r²) of its light. */
static void water_lies_around_a_plateau(void **state) {
  enum { ANGLES = 3600 };
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, make_plateau);
  const double degree_m = radius_m * NP_DEGREE, half[2] = {0.475 * degree_m * cos(44.5 * NP_DEGREE), 0.475 * degree_m};
  double beyond = 0.0;
  for (int i = 0; i < ANGLES; i++) {
    const double angle = 2.0 * NP_PI * (i + 0.5) / ANGLES;
    const double away_m = fmin(half[0] / fabs(cos(angle)), half[1] / fabs(sin(angle)));
    beyond += 8e3 / hypot(8e3, away_m) / ANGLES;
  }
  assert_near(np_terrain_measure_water(terrain, 50.0), beyond, 0.01);
  assert_near(np_terrain_measure_water(terrain, 150.0), 1.0, 0.0);
  const np_vec3 to_sun = np_vec3_normalize(np_vec3_make(0.0f, 1.0f, 0.5f));
  assert_near(np_terrain_measure_glint(terrain, 150.0, to_sun), 1.0, 0.0);
  assert_true(np_terrain_measure_glint(terrain, 50.0, to_sun) < 0.1); /* that along the northern border has it */
  neph_terrain_release(terrain);
}

static int make_ridge(unsigned column, unsigned row) { return (void)column, row > 590 && row < 610 ? 3000 : 0; }

/* A ridge of 3 km from west to east before a sun in the north, 10° high, shades 17 km of water to its south; air 100,
 * 500 and 2000 m above them, and as far beyond as it sees the sun ahead of itself in the water, lacks the glint. */
static void a_ridge_hides_the_glint(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, make_ridge);
  const double high = 10.0 * NP_DEGREE;
  const np_vec3 north = np_vec3_make(0.0f, (float)cos(high), (float)sin(high));
  const double hidden_m = (3000.0 + (100.0 + 500.0 + 2000.0) / 3.0) / tan(high);
  assert_near(np_terrain_measure_glint(terrain, 1.0, north), 1.0 - hidden_m / (radius_m * NP_DEGREE), 0.06);
  neph_terrain_release(terrain);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_plateau_goes_on_to_the_horizon),
      TEST(relief_goes_on_behind_the_border),
      TEST(a_border_at_sea_level_fades),
      TEST(a_wall_stands_at_the_border),
      TEST(water_lies_around_a_plateau),
      TEST(a_ridge_hides_the_glint),
      TEST(raw_samples_are_read_by_type_and_order),
      TEST(raw_samples_of_another_size_are_refused),
      TEST(colors_stand_for_heights),
      TEST(colors_that_are_none_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
