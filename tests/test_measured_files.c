/* SPDX-License-Identifier: Apache-2.0 */
/* Measured maps from GeoTIFF files: places, units, conversion, and what is wrong with a file. */
#include "test_clouds.h"
#include "test_geotiffs.h"

#include <stdarg.h>

#include <nephos/scene.h>

#include "optics/slab_reflectance.h"
#include "scene/scene_eval.h"

enum { EDGE = 12, ALL = EDGE * EDGE };

/* A point on the central meridian of zone 11 of UTM, at 34° N: its northing is 0.9996 times the meridian's arc. */
static const double easting_m = 500000.0, northing_m = 3762155.9776, central_scale = 0.9996;

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

/* 12 × 12 pixels of 500 m of the projection, around the point at 34° N, 117° W. */
static test_geotiff utm_tiff(void) {
  return (test_geotiff){.width = EDGE,
                        .height = EDGE,
                        .crs = "EPSG:32611",
                        .transform = {easting_m - 3000, 500, 0, northing_m + 3000, 0, -500}};
}

static void write_map(const test_fixture *f, const char *name, const test_geotiff *tiff, const float *values) {
  test_write_geotiff(f, name, tiff, values);
}

static void write_uniform(const test_fixture *f, const char *name, const test_geotiff *tiff, float value) {
  float values[ALL];
  for (int i = 0; i < ALL; i++) values[i] = value;
  write_map(f, name, tiff, values);
}

/* Checks that a message with some words was logged, beside others, and forgets all of them. */
static void check_message(test_fixture *f, const char *words) {
  if (!strstr(f->log.text, words)) fail_msg("no \"%s\" in: %s", words, f->log.text);
  test_log_clear(&f->log);
}

typedef struct column_map {
  int side;
  double voxel_m, *depths, *tops_m; /* tops above the base */
} column_map;

static void clear_columns(column_map *map) {
  free(map->depths);
  free(map->tops_m);
}

/* Bakes the first cloud of a scene, whose file is written beside the maps: "%s" in `map` is the keys of the map. */
static neph_result bake_scene(test_fixture *f, const char *map, const char *rest, column_map *out) {
  char *path = test_path(f->folder, "scene.yaml");
  FILE *file = fopen(path, "w");
  neph_scene *scene = NULL, at;
  assert_non_null(file);
  fprintf(file,
          "version: 1\nplace: {latitude: 34 deg, longitude: -117 deg}\natmosphere: {ground_albedo: 0}\nclouds:\n"
          "  - {phase: {hg: 0.85}, bake: {preset: stratocumulus, extent: [5 km, 5 km], voxel: 50 m, "
          "map: {%s}%s}}\n",
          map, rest ? rest : ", thickness: 400 m");
  fclose(file);
  *out = (column_map){.side = 0};
  neph_result result = neph_scene_load(f->context, path, &scene);
  if (!result) result = np_scene_eval(scene, 1, &at);
  if (!result) {
    const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
    const neph_cloud_desc *desc = &at.clouds[0].bake;
    np_sparse_grid grid;
    np_monitor monitor;
    np_monitor_start(&monitor, f->context, NULL, NULL);
    result = np_cloud_bake_grid(f->context, desc, &bake_desc, "density", &monitor, &grid);
    if (!result) {
      const int side = (int)round(desc->extent_m[0] / desc->voxel_m);
      *out = (column_map){side, desc->voxel_m, calloc((size_t)(side * side), sizeof(double)),
                          calloc((size_t)(side * side), sizeof(double))};
      for (size_t l = 0; l < grid.leaf_count; l++)
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const np_leaf *leaf = &grid.leaves[l];
          const int i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8, k = leaf->origin[2] + n % 8;
          if (i >= side || j >= side || !(leaf->values[n] > 0)) continue;
          double *top_m = &out->tops_m[j * side + i];
          out->depths[j * side + i] += (double)leaf->values[n] * desc->voxel_m;
          if (leaf->values[n] > 0.1f * (float)desc->extinction_per_m) *top_m = fmax(*top_m, (k + 1) * desc->voxel_m);
        }
      np_sparse_grid_clear(&grid);
    }
    np_scene_eval_clear(&at);
  }
  neph_scene_destroy(scene);
  free(path);
  return result;
}

static double average_depth(const column_map *map) {
  double sum = 0;
  for (int c = 0; c < map->side * map->side; c++) sum += map->depths[c];
  return sum / (map->side * map->side);
}

/* Checks that only columns of one pixel are cloudy, a parallelogram around a middle with two edges, and that the field
 * has the pixel's optical depth: to the area of columns that its border cuts. */
static void check_pixel(const column_map *map, const double middle_m[2], const double edges_m[2][2], double depth) {
  const double area = fabs(edges_m[0][0] * edges_m[1][1] - edges_m[0][1] * edges_m[1][0]);
  double nearest = 0;
  for (int c = 0; c < map->side * map->side; c++) {
    const double x_m = (c % map->side + 0.5 - 0.5 * map->side) * map->voxel_m - middle_m[0];
    const double y_m = (c / map->side + 0.5 - 0.5 * map->side) * map->voxel_m - middle_m[1];
    const double u = (x_m * edges_m[1][1] - y_m * edges_m[1][0]) / area;
    const double v = (y_m * edges_m[0][0] - x_m * edges_m[0][1]) / area, far = fmax(fabs(u), fabs(v));
    if (far > 0.5 + 1e-3) assert_near(map->depths[c], 0, 1e-6);
    if (map->depths[c] > 0) nearest = fmax(nearest, far);
  }
  assert_true(nearest > 0.4); /* up to the pixel's border */
  const double field = pow(map->side * map->voxel_m, 2);
  assert_near_relative(average_depth(map), depth * area / field, 2 * map->voxel_m / sqrt(area));
}

/* ---- Places ---- */

/* One cloudy pixel stands where the projection puts it, as many metres from the scene's place as on the ellipsoid:
 * projected lengths over the scale at the central meridian. */
static void a_pixel_of_a_projection_stands_in_its_place(void **state) {
  test_fixture *f = *state;
  float values[ALL] = {0};
  column_map map;
  const test_geotiff tiff = utm_tiff();
  const double middle_m[2] = {1250 / central_scale, 750 / central_scale}, edge_m = 500 / central_scale;
  const double edges_m[2][2] = {{edge_m, 0}, {0, edge_m}};
  values[4 * EDGE + 8] = 20;
  write_map(f, "map.tif", &tiff, values);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  check_pixel(&map, middle_m, edges_m, 20);
  clear_columns(&map);
}

/* The same of longitudes and latitudes, which are those of the planet's sphere of 6360 km; 243° E is 117° W. */
static void a_pixel_of_degrees_stands_in_its_place(void **state) {
  test_fixture *f = *state;
  float values[ALL] = {0};
  column_map map;
  const double metres = NP_DEGREE * 6360e3, shrunk = cos(34.0075 * NP_DEGREE);
  const test_geotiff tiff = {
      .width = EDGE, .height = EDGE, .crs = "EPSG:4326", .transform = {243 - 0.03, 0.005, 0, 34 + 0.03, 0, -0.005}};
  const double middle_m[2] = {0.0125 * metres * shrunk, 0.0075 * metres};
  const double edges_m[2][2] = {{0.005 * metres * shrunk, 0}, {0, 0.005 * metres}};
  values[4 * EDGE + 8] = 20;
  write_map(f, "map.tif", &tiff, values);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  check_pixel(&map, middle_m, edges_m, 20);
  clear_columns(&map);
}

/* A grid that is turned by 30° against north. */
static void a_turned_grid_is_turned_back(void **state) {
  test_fixture *f = *state;
  float values[ALL] = {0};
  column_map map;
  const double c = 500 * cos(30 * NP_DEGREE), s = 500 * sin(30 * NP_DEGREE), half = 0.5 * EDGE;
  const test_geotiff tiff = {
      .width = EDGE,
      .height = EDGE,
      .crs = "EPSG:32611",
      .transform = {easting_m - half * c - half * s, c, s, northing_m - half * s + half * c, s, -c}};
  const double middle_m[2] = {(2.5 * c - 0.5 * s) / central_scale, (2.5 * s + 0.5 * c) / central_scale};
  const double edges_m[2][2] = {{c / central_scale, s / central_scale}, {-s / central_scale, c / central_scale}};
  values[5 * EDGE + 8] = 20; /* 2.5 columns, -0.5 rows from the middle */
  write_map(f, "map.tif", &tiff, values);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  check_pixel(&map, middle_m, edges_m, 20);
  clear_columns(&map);
}

/* ---- Values ---- */

/* Counts with scale and offset, and a value without data, as satellites' files have. */
static void scale_and_offset_apply_and_voids_are_clear(void **state) {
  test_fixture *f = *state;
  float values[ALL];
  column_map map;
  test_geotiff tiff = utm_tiff();
  tiff.type = GDT_UInt16;
  tiff.scale = 0.01;
  tiff.offset = 2;
  tiff.has_void = true;
  tiff.empty = 65535;
  for (int i = 0; i < ALL; i++) values[i] = i % EDGE < EDGE / 2 ? 65535 : 800;
  write_map(f, "map.tif", &tiff, values);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  assert_near_relative(average_depth(&map), 0.5 * 10, 0.02);
  check_message(f, "map.tif: 72 of 144 pixels hold no data");
  clear_columns(&map);
}

/* Reflectances of a slab's table come back as its depths, by the sun of the keys, of the file, or divided by it. */
static void reflectances_become_depths(void **state) {
  test_fixture *f = *state;
  static const char *const maps[] = {"file: a.tif, quantity: reflectance, sun: {elevation: 30 deg}",
                                     "file: a.tif, quantity: reflectance",
                                     "file: b.tif, quantity: radiance_factor, sun: {elevation: 30 deg}",
                                     "file: c.tif, quantity: reflectance, sun: {elevation: 30 deg, azimuth: 100 deg}, "
                                     "view: {elevation: 45 deg, azimuth: 60 deg}, ground_albedo: 0.3"};
  const np_phase phase = np_phase_henyey_greenstein(0.85f);
  const np_slab_view zenith = {&phase, 1.0, 0.0, 0.5, 1.0, 0.0};
  const np_slab_view aside = {&phase, 1.0, 0.3, 0.5, sin(45 * NP_DEGREE), -40 * NP_DEGREE};
  np_slab_table tables[2];
  test_geotiff tiff = utm_tiff();
  assert_int_equal(np_slab_table_make(f->context, &zenith, &tables[0]), NEPH_OK);
  assert_int_equal(np_slab_table_make(f->context, &aside, &tables[1]), NEPH_OK);
  tiff.sun_elevation = "30";
  write_uniform(f, "a.tif", &tiff, (float)np_slab_table_eval(&tables[0], 12));
  write_uniform(f, "b.tif", &tiff, (float)(0.5 * np_slab_table_eval(&tables[0], 12)));
  write_uniform(f, "c.tif", &tiff, (float)np_slab_table_eval(&tables[1], 12));
  for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) {
    column_map map;
    assert_int_equal(bake_scene(f, maps[i], NULL, &map), NEPH_OK);
    assert_near_relative(average_depth(&map), 12, 0.01); /* the albedo of the cloud is 0.99999 or so */
    clear_columns(&map);
  }
}

static void a_bright_pixel_saturates(void **state) {
  test_fixture *f = *state;
  column_map map;
  const test_geotiff tiff = utm_tiff();
  write_uniform(f, "map.tif", &tiff, 1.05f);
  assert_int_equal(
      bake_scene(f, "file: map.tif, quantity: reflectance, sun: {elevation: 30 deg}, depth_max: 50", NULL, &map),
      NEPH_OK);
  assert_near_relative(average_depth(&map), 50, 0.01);
  check_message(f, "144 of 144 pixels");
  clear_columns(&map);
}

static void a_faint_pixel_is_clear(void **state) {
  test_fixture *f = *state;
  column_map map;
  const test_geotiff tiff = utm_tiff();
  write_uniform(f, "map.tif", &tiff, 0.5f);
  assert_int_equal(bake_scene(f, "file: map.tif, threshold: 1", NULL, &map), NEPH_OK);
  assert_near(average_depth(&map), 0, 0);
  check_message(f, "144 of 144 pixels have an optical depth below the threshold of 1");
  clear_columns(&map);
}

/* Fine pixels are averaged to some that hold columns. */
static void fine_pixels_are_averaged(void **state) {
  test_fixture *f = *state;
  enum { FINE = 300 };
  static float values[FINE * FINE];
  column_map map;
  test_geotiff tiff = utm_tiff();
  tiff.width = tiff.height = FINE;
  tiff.transform[1] = 20, tiff.transform[5] = -20;
  for (int i = 0; i < FINE * FINE; i++) values[i] = (i / FINE + i) % 2 ? 30 : 10;
  write_map(f, "map.tif", &tiff, values);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  assert_near_relative(average_depth(&map), 20, 0.01);
  check_message(f, "its pixels are 20 m");
  clear_columns(&map);
}

/* ---- Tops ---- */

static double average_top_m(const column_map *map, int column_begin, int column_end) {
  double sum = 0, count = 0;
  for (int c = 0; c < map->side * map->side; c++)
    if (map->tops_m[c] > 0 && c % map->side >= column_begin && c % map->side < column_end) {
      sum += map->tops_m[c];
      count++;
    }
  return sum / count;
}

/* Mean tops of columns are those of the map, in metres above the sea, on a grid of its own: to a voxel, whose upper
 * face is counted.
 */
static void tops_are_those_of_the_map(void **state) {
  test_fixture *f = *state;
  float heights[ALL], kelvins[ALL];
  column_map map;
  const test_geotiff tiff = utm_tiff();
  test_geotiff coarse = tiff;
  coarse.width = coarse.height = EDGE / 2;
  coarse.transform[1] = 1000, coarse.transform[5] = -1000;
  for (int i = 0; i < ALL / 4; i++) {
    heights[i] = i % (EDGE / 2) < EDGE / 4 ? 1400 : 1900;
    kelvins[i] = 288.15f - 0.0065f * heights[i];
  }
  write_uniform(f, "map.tif", &tiff, 15);
  write_map(f, "top.tif", &coarse, heights);
  write_map(f, "kelvin.tif", &coarse, kelvins);
  static const char *const maps[] = {"file: map.tif, top: top.tif",
                                     "file: map.tif, top: {file: kelvin.tif, quantity: temperature}",
                                     "file: map.tif, top: {file: kelvin.tif, quantity: temperature, "
                                     "ground_temperature: 289.45 K}"};
  for (int i = 0; i < 3; i++) {
    const double warmer_m = i == 2 ? 200 : 0; /* 1.3 K over 6.5 K/km */
    assert_int_equal(bake_scene(f, maps[i], ", top: 2500 m", &map), NEPH_OK);
    assert_near(average_top_m(&map, 5, 35), 1400 - 900 + warmer_m, 50);
    assert_near(average_top_m(&map, 65, 95), 1900 - 900 + warmer_m, 50);
    assert_near_relative(average_depth(&map), 15, 0.01);
    clear_columns(&map);
  }
}

static void tops_beyond_the_field_are_reported(void **state) {
  test_fixture *f = *state;
  column_map map;
  const test_geotiff tiff = utm_tiff();
  write_uniform(f, "map.tif", &tiff, 15);
  write_uniform(f, "top.tif", &tiff, 2000);
  assert_int_equal(bake_scene(f, "file: map.tif, top: top.tif", NULL, &map), NEPH_OK);
  check_message(f, "100 % of the cloudy columns have a measured top above the field's, 1300 m");
  clear_columns(&map);
}

/* ---- Refusals ---- */

typedef struct refusal {
  const char *map, *words;
} refusal;

static void what_is_wrong_is_named(void **state) {
  test_fixture *f = *state;
  test_geotiff tiff = utm_tiff(), far = utm_tiff(), bare = utm_tiff(), two = utm_tiff(), placed = utm_tiff();
  far.transform[0] += 40000;
  bare.crs = NULL;
  memset(bare.transform, 0, sizeof bare.transform);
  placed.crs = NULL;
  two.bands = 2;
  write_uniform(f, "ten.tif", &tiff, 10);
  write_uniform(f, "percent.tif", &tiff, 63);
  write_uniform(f, "negative.tif", &tiff, -3);
  write_uniform(f, "huge.tif", &tiff, 12000);
  write_uniform(f, "nothing.tif", &tiff, NAN);
  write_uniform(f, "far.tif", &far, 10);
  write_uniform(f, "bare.tif", &bare, 10);
  write_uniform(f, "placed.tif", &placed, 10);
  write_uniform(f, "two.tif", &two, 10);
  tiff.sun_elevation = "high";
  write_uniform(f, "sun.tif", &tiff, 0.5f);
  tiff.sun_elevation = "-4";
  write_uniform(f, "night.tif", &tiff, 0.5f);
  static const refusal refusals[] = {
      {"file: missing.tif", "no such file"},
      {"file: percent.tif, quantity: reflectance, sun: {elevation: 30 deg}", "reflectance is 63"},
      {"file: negative.tif", "optical depth is -3"},
      {"file: negative.tif, quantity: reflectance, sun: {elevation: 30 deg}", "reflectance is -3"},
      {"file: huge.tif", "optical depth is 12000"},
      {"file: nothing.tif", "has no data in any of the 144 pixels"},
      {"file: far.tif", "the map misses it"},
      {"file: bare.tif", "names no place"},
      {"file: placed.tif", "names no coordinate system"},
      {"file: ten.tif, size: 5 km", "leave out map.size"},
      {"file: two.tif", "holds 2 bands: choose one"},
      {"file: two.tif, band: 3", "band is 3"},
      {"file: ten.tif, top: {file: two.tif, band: 3}", "band is 3"},
      {"file: ten.tif, quantity: reflectance, sun: {elevation: 30 deg}", "reflectance is 10"},
      {"file: percent.tif, top: {file: ten.tif, quantity: temperature}", "brightness temperature is 10"},
      {"file: ten.tif, top: {file: huge.tif, quantity: temperature}", "brightness temperature is 12000"},
      {"file: sun.tif, quantity: reflectance", "SUN_ELEVATION \"high\""},
      {"file: night.tif, quantity: reflectance", "the sun's elevation is -4 deg"},
      {"file: ten.tif, quantity: radiance", "quantity"},
      {"file: ten.tif, image: a.png", "map"},
      {"file: ten.tif, coverage: R", "coverage is of an image"},
      {"file: ten.tif, top: {quantity: height}", "top has no file"},
  };
  for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
    column_map map;
    const neph_result result = bake_scene(f, refusals[i].map, NULL, &map);
    if (result == NEPH_OK || !strstr(f->log.text, refusals[i].words) || f->log.counts[NEPH_LOG_ERROR] != 1)
      fail_msg("%s: result %d, messages: %s", refusals[i].map, (int)result, f->log.text);
    test_log_clear(&f->log);
  }
}

static void a_missing_sun_is_named(void **state) {
  test_fixture *f = *state;
  column_map map;
  const test_geotiff tiff = utm_tiff();
  write_uniform(f, "map.tif", &tiff, 0.5f);
  assert_int_equal(bake_scene(f, "file: map.tif, quantity: reflectance", NULL, &map), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].bake.map.sun.elevation is missing", "SUN_ELEVATION");
  assert_int_equal(bake_scene(f,
                              "file: map.tif, quantity: reflectance, sun: {elevation: 30 deg}, "
                              "view: {elevation: 60 deg}",
                              NULL, &map),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].bake.map.sun.azimuth is missing", "SUN_AZIMUTH");
}

/* A ground as bright as a cloud hides it. */
static void a_bright_ground_is_refused(void **state) {
  test_fixture *f = *state;
  column_map map;
  const test_geotiff tiff = utm_tiff();
  write_uniform(f, "map.tif", &tiff, 0.9f);
  assert_int_equal(
      bake_scene(f, "file: map.tif, quantity: reflectance, sun: {elevation: 80 deg}, ground_albedo: 0.95, depth_max: 5",
                 NULL, &map),
      NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "ground_albedo is 0.95", "give no optical depth");
}

static void a_map_that_covers_a_part_is_reported(void **state) {
  test_fixture *f = *state;
  column_map map;
  test_geotiff tiff = utm_tiff();
  tiff.transform[0] += 3000;
  write_uniform(f, "map.tif", &tiff, 10);
  assert_int_equal(bake_scene(f, "file: map.tif", NULL, &map), NEPH_OK);
  assert_near_relative(average_depth(&map), 5, 0.02);
  check_message(f, "covers 50 % of the field");
  clear_columns(&map);
}

/* Without a coordinate system a map of a given size is laid around the middle of the field. */
static void a_bare_map_needs_a_size(void **state) {
  test_fixture *f = *state;
  column_map map;
  test_geotiff tiff = {.width = EDGE, .height = EDGE};
  write_uniform(f, "map.tif", &tiff, 10);
  assert_int_equal(bake_scene(f, "file: map.tif, size: 6 km", NULL, &map), NEPH_OK);
  assert_near_relative(average_depth(&map), 10, 0.01);
  clear_columns(&map);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_pixel_of_a_projection_stands_in_its_place),
      TEST(a_pixel_of_degrees_stands_in_its_place),
      TEST(a_turned_grid_is_turned_back),
      TEST(scale_and_offset_apply_and_voids_are_clear),
      TEST(reflectances_become_depths),
      TEST(a_bright_pixel_saturates),
      TEST(a_faint_pixel_is_clear),
      TEST(fine_pixels_are_averaged),
      TEST(tops_are_those_of_the_map),
      TEST(tops_beyond_the_field_are_reported),
      TEST(what_is_wrong_is_named),
      TEST(a_missing_sun_is_named),
      TEST(a_bright_ground_is_refused),
      TEST(a_map_that_covers_a_part_is_reported),
      TEST(a_bare_map_needs_a_size),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
