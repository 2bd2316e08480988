/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters that are refused, reduced, or too large for the memory. */
#include "test_rasters.h"

#include <unistd.h>

typedef struct refusal {
  const char *type, *members, *band, *complaint, *remedy;
} refusal;

static void headers_that_cannot_be_meant_are_refused(void **state) {
  test_fixture *f = *state;
  static const refusal refusals[] = {
      {"Byte", grid_members, "", "8-bit samples", "Int16 or Float32"},
      {"CFloat32", grid_members, "", "CFloat32 samples", "Float32"},
      {"Float32", "", "", "does not say where it lies", "terrain.width"},
      {"Float32", "<SRS>EPSG:32611</SRS><GeoTransform>0, 1, 2, 0, 2, 4</GeoTransform>", "", "lie on a line",
       "geotransform"},
      {"Float32", "<SRS>LOCAL_CS[\"site\",UNIT[\"metre\",1]]</SRS><GeoTransform>0,1,0,0,0,-1</GeoTransform>", "",
       "cannot be read", "site"},
      {"Float32", grid_members, "</VRTRasterBand><VRTRasterBand dataType=\"Float32\" band=\"2\">", "2 bands",
       "terrain.encoding"}};
  char *grid = write_grid(f, "grid.asc", 499900, northing_m, "1 2 3\n4 5 6");
  for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
    const refusal *r = &refusals[i];
    char *path = write_header(f, "header.vrt", r->type, r->members, r->band);
    np_heightfield field;
    neph_result result = load(f, path, NULL, &field);
    if (result != NEPH_ERROR_BAD_FILE) fail_msg("%s: result %d", r->complaint, (int)result);
    assert_null(field.elevation_m);
    if (i != 4) assert_one_error(&f->log, "header.vrt", r->complaint, r->remedy);
    test_log_clear(&f->log);
    free(path);
  }
  free(grid);
}

static void a_raster_of_voids_is_refused(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = describe_utm();
  char *path = write_grid(f, "grid.asc", 499900, northing_m, "-9999 -9999 -9999\n-9999 -9999 -9999");
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "grid.asc", "none of its 6 samples has a value");
  free(path);
}

/* A system of degrees over a grid of metres, by the scene and by the file itself; one around the planet's centre. */
static void coordinates_that_are_none_of_the_system_are_refused(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *crs, *complaint;
    double east, north;
  } cases[] = {{"EPSG:4326", "reaches latitude 3.8e+06 deg, must be within ±90: its coordinates are not degrees",
                391000, 3796000},
               {"EPSG:4267", "reaches latitude 290 deg, must be within ±90", 0, 190},
               {"EPSG:4326", "reaches longitude 3.91e+05 deg, must be within ±540", 391000, -50},
               {"EPSG:4978", "(WGS 84) is geocentric, must be projected or geographic", 391000, 3796000}};
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  unsigned size[2];
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char *path = write_grid(f, "grid.asc", cases[i].east, cases[i].north, "1 2 3\n4 5 6");
    desc.crs = cases[i].crs;
    assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&f->log, "grid.asc: ", cases[i].complaint, "check terrain.crs");
    assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_BAD_SCENE);
    test_log_clear(&f->log);
    free(path);
  }
  char *projection = write_text(f, "grid.prj",
                                "GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,"
                                "298.257223563]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]");
  char *path = write_grid(f, "grid.asc", 391000, 3796000, "1 2 3\n4 5 6");
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "reaches latitude 3.8e+06 deg", "give the right system with terrain.crs");
  free(path);
  free(projection);
}

/* Samples on both poles and on one meridian twice, whose header rounds the step; too wide by one more. */
static void the_whole_globe_is_taken(void **state) {
  test_fixture *f = *state;
  static const char globe[] = "<VRTDataset rasterXSize=\"%d\" rasterYSize=\"181\"><SRS>EPSG:4326</SRS>"
                              "<GeoTransform>-180.5, 1.00001, 0, 90.5, 0, -1.00001</GeoTransform>"
                              "<VRTRasterBand dataType=\"Int16\" band=\"1\"/></VRTDataset>";
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  unsigned size[2];
  char *path = write_text(f, "globe.vrt", globe, 361);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_OK);
  free(path);
  path = write_text(f, "globe.vrt", globe, 362);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "globe.vrt: is 361 deg wide, must be at most 360");
  free(path);
}

/* Covers degrees and a map projection, by the header and by loading. */
static void a_place_far_away_is_refused(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *crs;
    double east, north;
  } cases[] = {{"EPSG:32611", 499900, 3762156}, {"EPSG:4326", -117, 34}};
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  unsigned size[2];
  desc.has_place = true;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char *path = write_text(f, "grid.asc", "ncols 2\nnrows 2\nxllcenter %g\nyllcenter %g\ncellsize 0.01\n1 2 3 4\n",
                            cases[i].east, cases[i].north);
    desc.crs = cases[i].crs;
    desc.latitude_rad = 46.0 * NP_DEGREE;
    desc.longitude_rad = 8.0 * NP_DEGREE;
    assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, "latitude 46, longitude 8 deg", "km from the middle", "must be within 1000 km");
    assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, "latitude 46, longitude 8 deg", "km from the middle", "must be within 1000 km");
    desc.latitude_rad = 34.0 * NP_DEGREE;
    desc.longitude_rad = -117.0 * NP_DEGREE;
    assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_OK);
    free(path);
  }
}

static void copy_file(const char *from, const char *to, size_t size_max) {
  char *bytes = malloc(size_max);
  FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
  assert_true(bytes && in && out);
  const size_t size = fread(bytes, 1, size_max, in);
  assert_int_equal(fwrite(bytes, 1, size, out), size);
  assert_int_equal(fclose(in) + fclose(out), 0);
  free(bytes);
}

static void samples_without_their_header_are_refused(void **state) {
  test_fixture *f = *state;
  static const char header[] = "nrows 2\nncols 2\nnbits 16\nulxmap 500000\nulymap 3762156\nxdim 100\nydim 100\n";
  const neph_terrain_desc desc = describe_utm();
  np_heightfield field;
  char *path = write_text(f, "dem.bil", "abcdefgh");
  assert_int_equal(load(f, path, &desc, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "dem.bil: cannot be read: its header dem.hdr is missing beside it");
  char *beside = write_text(f, "dem.Hdr", header);
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  np_heightfield_destroy(f->context, &field);
  free(beside);
  free(path);
}

/* Cut short in its header, and in its samples; a text; a system that PROJ does not know. */
static void damaged_files_are_refused(void **state) {
  test_fixture *f = *state;
  char *source = test_data_path("dem/srtm_bigtujunga30m_utm11.tif"), *path = test_path(f->folder, "cut.tif");
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  for (size_t size = 100; size < 2000000; size *= 10000) {
    copy_file(source, path, size);
    assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, "cut.tif: cannot be read: ");
    assert_null(field.elevation_m);
  }
  free(path);
  path = write_text(f, "text.tif", "no picture at all");
  assert_int_equal(load(f, path, NULL, &field), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "text.tif: cannot be read: ");
  desc.crs = "EPSG:none";
  assert_int_equal(load(f, source, &desc, &field), NEPH_ERROR_BAD_SCENE); /* not the file's fault */
  assert_one_error(&f->log, "terrain.crs is \"EPSG:none\", must be a coordinate system that is known");
  free(path);
  free(source);
}

/* Decided by the headers alone: 144 million samples are averaged, a million along a side are refused. */
static void huge_rasters_are_averaged_or_refused(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  static const char raster[] = "<VRTDataset rasterXSize=\"%d\" rasterYSize=\"%d\">%s"
                               "<VRTRasterBand dataType=\"Int16\" band=\"1\"/></VRTDataset>";
  unsigned size[2];
  char *path = write_text(f, "huge.vrt", raster, 12000, 12000, grid_members);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_OK);
  assert_true(size[0] == 6000 && size[1] == 6000);
  free(path);
  path = write_text(f, "huge.vrt", raster, 10801, 10801, grid_members);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_OK);
  assert_true(size[0] == 10801 && size[1] == 10801);
  free(path);
  path = write_text(f, "huge.vrt", raster, 1000000, 1000000, grid_members);
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "huge.vrt", "1000000 × 1000000", "200000", "gdal_translate -projwin");
  free(path);
}

/* Averages of 2 × 2 samples stand in the middle of each four: 200 rows of 20,000 are too long, and their place stays.
 */
static void averages_stand_in_the_middle(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  char *slope = write_text(f, "slope.asc", "ncols 2\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 1\n0 100\n0 100\n");
  char *path = write_text(f, "long.vrt",
                          "<VRTDataset rasterXSize=\"20000\" rasterYSize=\"4\"><SRS>EPSG:32611</SRS>"
                          "<GeoTransform>490000, 1, 0, 3762156, 0, -1</GeoTransform>"
                          "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                          "<SourceFilename relativeToVRT=\"1\">slope.asc</SourceFilename>"
                          "<SrcRect xOff=\"0\" yOff=\"0\" xSize=\"2\" ySize=\"2\"/>"
                          "<DstRect xOff=\"0\" yOff=\"0\" xSize=\"20000\" ySize=\"4\"/>"
                          "</SimpleSource></VRTRasterBand></VRTDataset>");
  np_heightfield field;
  assert_int_equal(load(f, path, &desc, &field), NEPH_OK);
  assert_int_equal(field.width, 10000);
  assert_int_equal(field.height, 2);
  assert_non_null(strstr(f->log.text, "averaged in squares of 2 to 10000 × 2"));
  assert_near(field.step_east_rad * radius_m, 2.0 / 0.9996, 1e-5);
  assert_near(field.origin.longitude_rad / NP_DEGREE, -117.0, 1e-9); /* the centre */
  assert_true(get_sample(&field, 4999, 0) == 0.0f && get_sample(&field, 5000, 0) == 100.0f);
  np_heightfield_destroy(f->context, &field);
  free(path);
  free(slope);
}

/* Each failed allocation ends the load with one message. GDAL's own memory is not the context's. */
static neph_result load_tiles(neph_context *context, void *name) {
  const neph_terrain_desc desc = describe_utm();
  np_heightfield field;
  neph_result result = np_heightfield_load(context, NULL, name, &desc, &field);
  if (!result) np_heightfield_destroy(context, &field);
  return result;
}

static void failed_allocations_are_survived(void **state) {
  test_fixture *f = *state;
  char *paths[] = {write_grid(f, "tile_a.asc", 499900, northing_m, "1 2 3\n7 8 9"),
                   write_grid(f, "tile_b.asc", 500200, northing_m, "4 5 6\n10 11 12")};
  char *name = test_path(f->folder, "tile_?.asc");
  assert_survives_failed_allocations(load_tiles, name);
  free(name);
  for (int i = 0; i < 2; i++) free(paths[i]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(headers_that_cannot_be_meant_are_refused),
      TEST(a_raster_of_voids_is_refused),
      TEST(coordinates_that_are_none_of_the_system_are_refused),
      TEST(the_whole_globe_is_taken),
      TEST(a_place_far_away_is_refused),
      TEST(samples_without_their_header_are_refused),
      TEST(damaged_files_are_refused),
      TEST(huge_rasters_are_averaged_or_refused),
      TEST(averages_stand_in_the_middle),
      TEST(failed_allocations_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
