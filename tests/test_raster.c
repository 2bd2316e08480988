/* SPDX-License-Identifier: Apache-2.0 */
/* Georeferenced rasters by GDAL: places and elevations that are known. Small rasters are texts:
 * .asc, and .vrt where a header must say more. */
#include "test_rasters.h"

#include <dlfcn.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/module.h"

/* ---- Need ---- */

static int lie_flat(unsigned column, unsigned row) { return (void)column, (void)row, 7; }

/* First of all tests: a process keeps what it has loaded. */
static void a_tile_of_srtm_loads_no_gdal(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N10E010.hgt", 1201, lie_flat);
  np_heightfield field;
  assert_int_equal(load(f, path, NULL, &field), NEPH_OK);
  np_heightfield_destroy(f->context, &field);
  assert_null(dlopen("libgdal.so.32", RTLD_NOW | RTLD_NOLOAD));
  assert_null(dlopen(NEPHOS_TEST_MODULE_DIR "/nephos_gdal.so", RTLD_NOW | RTLD_NOLOAD));
  free(path);
}

static void a_module_that_is_missing_is_said_to_be(void **state) {
  test_fixture *f = *state;
  const np_module_kind kind = {"nephos_none.so", "nephos_none_module", 1, "reads nothing", 0, 0};
  const void *table;
  assert_false(np_module_is_present(f->context, &kind));
  assert_int_equal(np_module_get(f->context, &kind, &table), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, "cannot load nephos_none.so, which reads nothing", "not there");
  assert_null(table);
  assert_true(neph_feature_is_present(f->context, NEPH_FEATURE_GDAL));
}

/* ---- Places ---- */

/* The tile by its own reader and, by a name with ?, through GDAL. Its place comes from degrees that GDAL rounds to
 * doubles: some 1e-15. */
static void a_tile_of_srtm_is_the_same_by_gdal(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("dem/N22W160.hgt"), *name = strdup(path);
  *strstr(name, "0.hgt") = '?';
  np_heightfield own, by_gdal;
  assert_int_equal(load(f, path, NULL, &own), NEPH_OK);
  assert_int_equal(load(f, name, NULL, &by_gdal), NEPH_OK);
  assert_int_equal(by_gdal.width, own.width);
  assert_int_equal(by_gdal.height, own.height);
  assert_int_equal(by_gdal.void_count, 4279);
  assert_false(by_gdal.has_chart);
  assert_near(by_gdal.west_rad, own.west_rad, 1e-13);
  assert_near(by_gdal.south_rad, own.south_rad, 1e-13);
  assert_near(by_gdal.step_east_rad, own.step_east_rad, 1e-15);
  assert_near(by_gdal.step_north_rad, own.step_north_rad, 1e-15);
  assert_memory_equal(by_gdal.elevation_m, own.elevation_m, (size_t)own.width * own.height * sizeof(float));
  np_heightfield_destroy(f->context, &own);
  np_heightfield_destroy(f->context, &by_gdal);
  free(path);
  free(name);
}

/* Pixels of a GeoTIFF in UTM, with the values of gdallocationinfo and the places of gdaltransform. At its place a pixel
 * lies in the world's origin: up to the slope over 1e-6 of a cell, the elevation there is its value. */
static void pixels_of_a_geotiff_stand_at_their_places(void **state) {
  test_fixture *f = *state;
  static const struct {
    double latitude, longitude, elevation_m;
  } pixels[] = {{34.4051725623102, -118.345567895661, 945},
                {34.3203341674028, -118.149228674883, 1265},
                {34.2351724128239, -117.953278332509, 872},
                {34.2702864183229, -118.310828939126, 413},
                {34.3874981847349, -118.018962455602, 1822}};
  char *path = test_data_path("dem/srtm_bigtujunga30m_utm11.tif");
  for (size_t i = 0; i < sizeof pixels / sizeof *pixels; i++) {
    neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
    neph_terrain *terrain = NULL;
    desc.has_place = true;
    desc.latitude_rad = pixels[i].latitude * NP_DEGREE;
    desc.longitude_rad = pixels[i].longitude * NP_DEGREE;
    assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
    assert_near(neph_terrain_get_elevation_m(terrain, 0, 0), pixels[i].elevation_m, 0.001);
    neph_terrain_release(terrain);
  }
  free(path);
}

/* Distance and azimuth on the ellipsoid, by Vincenty's formulas (1975), from the middle pixel above to the first and
 * the last. The file's grid is kept: 1197 × 643. */
static void distances_of_a_geotiff_are_those_of_the_ellipsoid(void **state) {
  test_fixture *f = *state;
  static const struct {
    unsigned column, row;
    double distance_m, azimuth_deg;
  } ends[] = {{0, 642, 20366.087, -62.42235}, {1196, 0, 20367.040, 117.57909}};
  char *path = test_data_path("dem/srtm_bigtujunga30m_utm11.tif");
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  desc.has_place = true;
  desc.latitude_rad = 34.3203341674028 * NP_DEGREE;
  desc.longitude_rad = -118.149228674883 * NP_DEGREE;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_true(field.has_chart && field.width == 1197 && field.height == 643);
  assert_true(field.elevation_min_m == 315.0f && field.elevation_max_m == 2295.0f);
  const np_globe globe = np_globe_make(radius_m, desc.latitude_rad, desc.longitude_rad);
  for (size_t i = 0; i < 2; i++) {
    const np_dvec3 p = np_heightfield_to_world(&field, &globe, (np_field_position){ends[i].column, ends[i].row}, 0);
    assert_near(radius_m * asin(hypot(p.x, p.y) / radius_m), ends[i].distance_m, 0.01);
    assert_near(atan2(p.x, p.y) / NP_DEGREE, ends[i].azimuth_deg, 0.0005);
  }
  np_heightfield_destroy(f->context, &field);
  free(path);
}

static void cells_of_a_projection_have_their_true_size(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = describe_utm();
  char *path = write_grid(f, "grid.asc", 499900, northing_m - 100, "1 2 3\n4 5 6");
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_near(field.origin.latitude_rad / NP_DEGREE, 34.0 - 50.0 / 0.9996 / 6371e3 / NP_DEGREE, 3e-6);
  assert_near(field.origin.longitude_rad / NP_DEGREE, -117.0, 1e-9);
  assert_near(field.step_east_rad * radius_m, 100.0 / 0.9996, 1e-4);
  assert_near(field.step_north_rad * radius_m, 100.0 / 0.9996, 1e-4);
  for (unsigned i = 0; i < 6; i++) assert_true(get_sample(&field, i % 3, 1 - i / 3) == (float)(i + 1));
  np_heightfield_destroy(f->context, &field);
  free(path);
}

/* Web Mercator at 60° stretches by two, nearly: 1/cosφ over the ellipsoid's own radius. Cells may be oblong. */
static void other_projections_and_oblong_cells_are_read(void **state) {
  test_fixture *f = *state;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.crs = "EPSG:3857";
  char *path =
      write_text(f, "mercator.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 8399537\ndx 100\ndy 200\n1 2\n3 4\n");
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_near(field.origin.latitude_rad / NP_DEGREE, 60.0, 0.003);
  assert_near(field.step_east_rad * radius_m, 50.0, 0.2);
  assert_near(field.step_north_rad * radius_m, 100.0, 0.4);
  np_heightfield_destroy(f->context, &field);
  free(path);
}

/* Rows run to the north-east, columns to the south-east: the first sample is the southern end of the western side. */
static void a_rotated_grid_stands_as_it_is_turned(void **state) {
  test_fixture *f = *state;
  char *grid = write_grid(f, "grid.asc", 0, 0, "1 2 3\n4 5 6");
  char *path = write_header(f, "rotated.vrt", "Float32",
                            "<SRS>EPSG:32611</SRS>"
                            "<GeoTransform>500000, 60, -80, 3762156, -80, -60</GeoTransform>",
                            "");
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  const np_globe globe = np_globe_make(radius_m, field.origin.latitude_rad, field.origin.longitude_rad);
  const np_dvec3 first = np_heightfield_to_world(&field, &globe, (np_field_position){0, 1}, 0);
  const np_dvec3 next = np_heightfield_to_world(&field, &globe, (np_field_position){1, 1}, 0);
  const np_dvec3 below = np_heightfield_to_world(&field, &globe, (np_field_position){0, 0}, 0);
  assert_true(get_sample(&field, 0, 1) == 1.0f && get_sample(&field, 1, 1) == 2.0f && get_sample(&field, 0, 0) == 4.0f);
  assert_near(next.x - first.x, 60.0 / 0.9996, 0.01);
  assert_near(next.y - first.y, -80.0 / 0.9996, 0.01);
  assert_near(below.x - first.x, -80.0 / 0.9996, 0.01);
  assert_near(below.y - first.y, -60.0 / 0.9996, 0.01);
  np_heightfield_destroy(f->context, &field);
  free(path);
  free(grid);
}

/* ---- Elevations ---- */

static void units_are_the_files_or_those_given(void **state) {
  test_fixture *f = *state;
  char *grid = write_grid(f, "grid.asc", 499900, northing_m, "1000 2000 3000\n4000 5000 6000");
  char *path = write_header(f, "feet.vrt", "Float32", grid_members, "<UnitType>ft</UnitType>");
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  static const double units_m[] = {0.3048, 1.0, 0.3048, 1200.0 / 3937.0};
  for (unsigned unit = 0; unit < 4; unit++) {
    np_heightfield field;
    desc.unit = (neph_height_unit)unit;
    assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
    assert_near((double)get_sample(&field, 2, 0), 6000 * units_m[unit], 2e-4); /* stored as float */
    np_heightfield_destroy(f->context, &field);
  }
  free(path);
  path = write_header(f, "fathoms.vrt", "Float32", grid_members, "<UnitType>fathom</UnitType>");
  np_heightfield field;
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "fathoms.vrt", "\"fathom\"", "terrain.vertical_unit");
  free(path);
  free(grid);
}

static void voids_are_filled_counted_and_told(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = describe_utm();
  char *path = write_grid(f, "grid.asc", 499900, northing_m, "10.5 -9999 30\n10.5 nan 30");
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_int_equal(field.void_count, 2);
  assert_true(field.elevation_min_m == 10.5f && field.elevation_max_m == 30.0f);
  assert_true(get_sample(&field, 1, 0) > 10.5f && get_sample(&field, 1, 0) < 30.0f);
  assert_non_null(strstr(f->log.text, "2 of 6 samples have no value and are filled"));
  np_heightfield_destroy(f->context, &field);
  free(path);
}

/* An .hdr is the header of a .bil, and of nothing else that bears its name. */
static void headers_beside_other_files_are_not_theirs(void **state) {
  test_fixture *f = *state;
  neph_terrain_desc desc = describe_utm();
  const int16_t samples[] = {1, 2, 3, 4, 5, 600};
  char *header = write_text(f, "grid.hdr",
                            "nrows 2\nncols 3\nnbits 16\npixeltype signedint\nbyteorder I\nulxmap 499900\n"
                            "ulymap %.3f\nxdim 100\nydim 100\n",
                            northing_m);
  char *text = write_grid(f, "grid.asc", 499900, northing_m - 100, "1 2 3\n4 5 600");
  char *raw = test_path(f->folder, "grid.bil");
  np_heightfield by_text, by_header;
  FILE *file = fopen(raw, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(samples, sizeof samples, 1, file), 1);
  assert_int_equal(fclose(file), 0);
  assert_int_equal(load(f, text, &desc, &by_text), NEPH_OK);
  assert_int_equal(load(f, raw, &desc, &by_header), NEPH_OK);
  assert_memory_equal(by_text.elevation_m, by_header.elevation_m, 6 * sizeof(float));
  assert_near(by_header.origin.latitude_rad, by_text.origin.latitude_rad, 1e-12);
  assert_near(by_header.origin.longitude_rad, by_text.origin.longitude_rad, 1e-12);
  np_heightfield_destroy(f->context, &by_text);
  np_heightfield_destroy(f->context, &by_header);
  free(header);
  free(text);
  free(raw);
}

/* Two tiles side by side, and a third row apart from them: what lies between is a void. */
static void tiles_are_joined(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = describe_utm();
  char *paths[] = {write_grid(f, "tile_a.asc", 499900, northing_m, "1 2 3\n7 8 9"),
                   write_grid(f, "tile_b.asc", 500200, northing_m, "4 5 6\n10 11 12"),
                   write_grid(f, "tile_c.asc", 499900, northing_m - 300, "1 2 3\n1 2 3")};
  char *name = test_path(f->folder, "tile_?.asc");
  np_heightfield field;
  assert_int_equal(load(f, name, &desc, &field), NEPH_OK);
  assert_int_equal(field.width, 6);
  assert_int_equal(field.height, 5);
  assert_int_equal(field.void_count, 6 + 2 * 3);
  for (unsigned column = 0; column < 6; column++) {
    assert_true(get_sample(&field, column, 4) == (float)(column + 1));
    assert_true(get_sample(&field, column, 3) == (float)(column + 7));
  }
  np_heightfield_destroy(f->context, &field);
  assert_int_equal(load(f, name, NULL, &field), NEPH_ERROR_BAD_FILE); /* without a coordinate system */
  assert_one_error(&f->log, "tile_?.asc (3 files)", "terrain.crs");
  free(name);
  name = test_path(f->folder, "tail_*.asc");
  assert_int_equal(load(f, name, &desc, &field), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "tail_*.asc", "no file matches");
  free(name);
  for (int i = 0; i < 3; i++) free(paths[i]);
}

/* An archive with one member that is not compressed (PKWARE, APPNOTE 6.3). */
static uint32_t compute_crc(const uint8_t *bytes, size_t size) {
  uint32_t crc = ~0u;
  for (size_t i = 0; i < size; i++) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

static void write_words(FILE *file, const uint16_t *words, size_t count) {
  for (size_t i = 0; i < count; i++) assert_true(fputc(words[i] & 255, file) >= 0 && fputc(words[i] >> 8, file) >= 0);
}

static char *write_archive(const test_fixture *f, const char *name, const char *member, const void *bytes,
                           size_t size) {
  char *path = test_path(f->folder, name);
  FILE *file = fopen(path, "wb");
  const uint32_t crc = compute_crc(bytes, size);
  const uint16_t crc_low = (uint16_t)crc, crc_high = (uint16_t)(crc >> 16), low = (uint16_t)size,
                 high = (uint16_t)(size >> 16), length = (uint16_t)strlen(member);
  const uint32_t at = (uint32_t)(30 + length + size), held = 46u + length;
  const uint16_t local[] = {0x4b50, 0x0403, 20, 0, 0, 0, 33, crc_low, crc_high, low, high, low, high, length, 0};
  const uint16_t central[] = {0x4b50, 0x0201, 20,     20, 0, 0, 0, 33, crc_low, crc_high, low, high,
                              low,    high,   length, 0,  0, 0, 0, 0,  0,       0,        0};
  const uint16_t end[] = {0x4b50, 0x0605, 0, 0, 1, 1, (uint16_t)held, 0, (uint16_t)at, (uint16_t)(at >> 16), 0};
  assert_non_null(file);
  write_words(file, local, 15);
  assert_int_equal(fwrite(member, length, 1, file), 1);
  assert_int_equal(fwrite(bytes, size, 1, file), 1);
  write_words(file, central, 23);
  assert_int_equal(fwrite(member, length, 1, file), 1);
  write_words(file, end, 11);
  assert_int_equal(fclose(file), 0);
  return path;
}

static void a_zipped_tile_is_read(void **state) {
  test_fixture *f = *state;
  enum { SIDE = 1201 };
  uint8_t *tile = calloc(SIDE * SIDE, 2);
  for (int i = 0; i < SIDE * SIDE; i++) tile[2 * i + 1] = (uint8_t)(i % SIDE % 200);
  char *path = write_archive(f, "S16E166.SRTMGL3.hgt.zip", "S16E166.hgt", tile, 2 * SIDE * SIDE);
  np_heightfield field;
  assert_int_equal(load(f, path, NULL, &field), NEPH_OK);
  assert_int_equal(field.width, SIDE);
  assert_near(field.south_rad, -16 * NP_DEGREE, 1e-13);
  assert_near(field.west_rad, 166 * NP_DEGREE, 1e-13);
  assert_true(get_sample(&field, 17, 5) == 17.0f && get_sample(&field, 203, 1200) == 3.0f);
  np_heightfield_destroy(f->context, &field);
  FILE *file = fopen(path, "r+b");
  assert_true(file && fputc('X', file) == 'X' && fclose(file) == 0); /* no header before the member */
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "S16E166.SRTMGL3.hgt.zip: cannot be read: ");
  free(path);
  path = write_archive(f, "notes.zip", "notes.txt", tile, 100);
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "notes.zip", "no raster of heights in the archive");
  free(path);
  free(tile);
}

/* ---- Without a coordinate system ---- */

static void a_raster_without_a_place_is_laid_out_like_a_picture(void **state) {
  test_fixture *f = *state;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *path = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6");
  np_heightfield field;
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "grid.asc", "names no coordinate system", "terrain.crs", "terrain.width");
  desc.has_width = true;
  desc.width_m = 4000;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_false(field.has_place || field.has_chart);
  assert_near(field.step_east_rad * radius_m, 2000, 1e-9);
  assert_near(field.step_north_rad * radius_m, 2000, 1e-9);
  assert_true(get_sample(&field, 2, 0) == 6.0f);
  np_heightfield_destroy(f->context, &field);
  desc.crs = utm_11;
  assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "grid.asc", "UTM zone 11N", "leave out terrain.width");
  free(path);
}

/* ---- Precision ---- */

/* A plain of 200 km in UTM, 1234.5 m high, met 100 km from its middle by rays from 30 km above. Facets of 500 m are
 * chords that dip by 500²·2/8R, 10 mm; floats have 8 mm there. */
static void elevations_hold_within_5_cm_at_100_km(void **state) {
  test_fixture *f = *state;
  enum { SIDE = 401 };
  char *path = test_path(f->folder, "plain.asc");
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fprintf(file, "ncols %d\nnrows %d\nxllcenter 400000\nyllcenter 3662156\ncellsize 500\n", SIDE, SIDE);
  for (int i = 0; i < SIDE * SIDE; i++) fprintf(file, i % SIDE == SIDE - 1 ? "1234.5\n" : "1234.5 ");
  assert_int_equal(fclose(file), 0);
  neph_terrain_desc desc = describe_utm();
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  for (int i = 0; i < 360; i++) {
    const double azimuth = i * NP_DEGREE, distance = 99.9e3;
    const np_dvec3 origin = np_dvec3_make(0.6 * distance * sin(azimuth), 0.6 * distance * cos(azimuth), 30e3);
    const np_vec3 direction = np_vec3_normalize(
        np_vec3_make((float)(0.4 * distance * sin(azimuth)), (float)(0.4 * distance * cos(azimuth)), -29.6e3f));
    np_terrain_hit hit;
    assert_true(np_terrain_intersect(terrain, origin, direction, INFINITY, &hit));
    const np_dvec3 at = np_dvec3_along(origin, direction, hit.distance);
    assert_true(hypot(at.x, at.y) > 97e3);
    assert_near(np_altitude(at, radius_m), 1234.5, 0.05);
    assert_near(neph_terrain_get_elevation_m(terrain, at.x, at.y), 1234.5, 1e-3);
  }
  neph_terrain_release(terrain);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_tile_of_srtm_loads_no_gdal),
      TEST(a_module_that_is_missing_is_said_to_be),
      TEST(a_tile_of_srtm_is_the_same_by_gdal),
      TEST(pixels_of_a_geotiff_stand_at_their_places),
      TEST(distances_of_a_geotiff_are_those_of_the_ellipsoid),
      TEST(cells_of_a_projection_have_their_true_size),
      TEST(other_projections_and_oblong_cells_are_read),
      TEST(a_rotated_grid_stands_as_it_is_turned),
      TEST(units_are_the_files_or_those_given),
      TEST(voids_are_filled_counted_and_told),
      TEST(headers_beside_other_files_are_not_theirs),
      TEST(tiles_are_joined),
      TEST(a_zipped_tile_is_read),
      TEST(a_raster_without_a_place_is_laid_out_like_a_picture),
      TEST(elevations_hold_within_5_cm_at_100_km),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
