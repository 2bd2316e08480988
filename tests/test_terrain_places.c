/* SPDX-License-Identifier: Apache-2.0 */
/* Place and border of the ground, and failures in making it. */
#include "test_terrains.h"

#include <png.h>
#include <time.h>
#include <unistd.h>

#include <nephos/image.h>

#include "core/random.h"

/* ---- Extent and place ---- */

static int stand_high(unsigned column, unsigned row) { return (void)column, (void)row, 800; }

static void the_rim_meets_the_sphere(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_tile(f, stand_high);
  const double half_height = 0.5 * NP_DEGREE * radius_m; /* arc length */
  const double rim_y = radius_m * sin(0.5 * NP_DEGREE);
  assert_true(half_height > rim_y);
  assert_true(np_terrain_covers(terrain, 0, 0));
  assert_true(np_terrain_covers(terrain, 0, rim_y - 0.01));
  assert_false(np_terrain_covers(terrain, 0, rim_y + 0.01));
  assert_false(np_terrain_covers(terrain, 7e6, 0));
  assert_near(neph_terrain_get_elevation_m(terrain, 0, rim_y - 0.01), 0, 0.01);
  assert_true(neph_terrain_get_elevation_m(terrain, 0, rim_y + 1) == 0);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, 0.89 * rim_y), 800, 1e-3); /* within the inner 90 % */
  assert_near(neph_terrain_get_elevation_m(terrain, 0, 0.95 * rim_y), 400, 10);   /* half-way down */
  np_dvec3 low, high;
  np_terrain_get_bounds(terrain, &low, &high);
  assert_near(high.z, 800, 1e-3);
  /* The rim is a parallel: seen from the middle's meridian its ends lie R·sinφ₀·cosφ·(1 − cosλ) farther north. */
  const double end_y = rim_y + radius_m * sin(44.5 * NP_DEGREE) * cos(45 * NP_DEGREE) * (1 - cos(0.5 * NP_DEGREE));
  assert_near(high.y, end_y, surface_tolerance_m);
  assert_near(np_terrain_get_elevation_min_m(terrain), 0, 0);
  neph_terrain_release(terrain);
}

static void the_place_is_the_middle_or_as_given(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N44W072.hgt", 1201, stand_high);
  neph_terrain_desc desc = describe_fading();
  neph_terrain *terrain = NULL;
  double latitude, longitude;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  assert_true(np_terrain_get_place(terrain, &latitude, &longitude));
  assert_near(latitude, 44.5 * NP_DEGREE, 1e-12);
  assert_near(longitude, -71.5 * NP_DEGREE, 1e-12);
  neph_terrain_release(terrain);

  desc.has_place = true;
  desc.latitude_rad = 44.9 * NP_DEGREE;
  desc.longitude_rad = -71.5 * NP_DEGREE;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  np_dvec3 low, high;
  np_terrain_get_bounds(terrain, &low, &high);
  /* 0.1° north of the place, and at its ends R·sinφ₀·cosφ·(1 − cosλ), 121 m, more. */
  assert_near(high.y, radius_m * sin(0.1 * NP_DEGREE) + 121, 0.5);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, -40e3), 800, 1e-3);
  neph_terrain_release(terrain);

  desc.latitude_rad = -44.5 * NP_DEGREE;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "latitude -44.5", "must be within 1000 km");
  assert_null(terrain);
  unsigned size[2];
  assert_int_equal(np_heightfield_check(f->context, path, &desc, size), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "latitude -44.5", "must be within 1000 km");
  free(path);
}

/* Ridges stand wherever they are put, and have no place of their own. */
static void ridges_take_the_place_given(void **state) {
  test_fixture *f = *state;
  double latitude, longitude;
  neph_terrain *terrain = make_ridges(f->context, 33);
  assert_false(np_terrain_get_place(terrain, &latitude, &longitude));
  const double middle_m = neph_terrain_get_elevation_m(terrain, 0, 0);
  neph_terrain_release(terrain);

  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 33;
  neph_terrain_desc desc = describe_fading();
  desc.has_place = true;
  desc.latitude_rad = 1.4;
  desc.longitude_rad = -3.0;
  assert_int_equal(neph_terrain_create_ridges(f->context, &ridges, &desc, &terrain), NEPH_OK);
  assert_true(np_terrain_get_place(terrain, &latitude, &longitude));
  assert_near(latitude, 1.4, 0);
  assert_near(longitude, -3.0, 0);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, 0), middle_m, 0);
  neph_terrain_release(terrain);
}

/* The summit is 1916.7 m high at 44.2705 N, 71.3033 W; SRTM's samples, 90 m apart, reach 1908. */
static void mount_washington_is_where_it_is(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("dem/N44W072.hgt");
  neph_terrain_desc desc = describe_fading();
  desc.has_place = true;
  desc.latitude_rad = 44.2705 * NP_DEGREE;
  desc.longitude_rad = -71.3033 * NP_DEGREE;
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  assert_near(neph_terrain_get_elevation_m(terrain, 0, 0), 1908, 10);
  neph_terrain_release(terrain);
  free(path);
}

static void an_island_reaches_below_the_sea(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("dem/N22W160.hgt");
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, NULL, &terrain), NEPH_OK);
  assert_true(np_terrain_get_elevation_min_m(terrain) < 0);
  neph_terrain_release(terrain);
  free(path);
}

/* ---- Failures ---- */

static void bad_descriptions_are_refused(void **state) {
  test_fixture *f = *state;
  const neph_terrain_desc good = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain_desc bad[6] = {good, good, good, good, good, good};
  const char *words[6] = {"planet_radius_m is nan",  "width is 0",     "latitude 2", "longitude inf",
                          "ground_albedo[1] is 1.5", "terrain heights"};
  bad[0].planet_radius_m = NAN;
  bad[1].width_m = 0;
  bad[2].latitude_rad = 2;
  bad[3].longitude_rad = INFINITY;
  bad[4].ground_albedo[1] = 1.5;
  bad[5].height_max_m = 1e9;
  for (int i = 0; i < 6; i++) {
    neph_terrain *terrain = (neph_terrain *)f;
    assert_int_equal(neph_terrain_create_ridges(f->context, NULL, &bad[i], &terrain), NEPH_ERROR_INVALID_ARGUMENT);
    assert_null(terrain);
    assert_one_error(&f->log, words[i]);
  }
}

static void bad_ridges_are_refused(void **state) {
  test_fixture *f = *state;
  const neph_ridges_desc good = NEPH_RIDGES_DESC_DEFAULT;
  neph_ridges_desc bad[4] = {good, good, good, good};
  const char *words[4] = {"sample_count is 1", "sample_count is 20000", "relief is -1", "at least two samples (58.5"};
  bad[0].sample_count = 1;
  bad[1].sample_count = 20000;
  bad[2].relief_m = -1;
  bad[3].ridge_m = 50;
  for (int i = 0; i < 4; i++) {
    neph_terrain *terrain = NULL;
    assert_int_equal(neph_terrain_create_ridges(f->context, &bad[i], NULL, &terrain), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, words[i]);
  }
}

typedef struct canceller {
  const char *stage;
  int reports; /* reports of that stage */
  struct timespec when;
} canceller;

/* Stops a stage in its midst: at the second report, since the first comes before any work. */
static bool cancel_in_stage(void *user, const neph_progress *progress) {
  canceller *cancel = user;
  if (strcmp(progress->stage, cancel->stage) || ++cancel->reports < 2) return true;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cancel->when);
  return false;
}

/* The promise of half a second, in processor time of both our threads: other programs do not stretch that. */
static void assert_cancelled(test_fixture *f, const char *stage,
                             neph_result (*make)(test_fixture *f, const neph_terrain_desc *desc)) {
  canceller cancel = {.stage = stage};
  neph_terrain_desc desc = describe_fading();
  desc.progress = cancel_in_stage;
  desc.progress_user = &cancel;
  assert_int_equal(make(f, &desc), NEPH_ERROR_CANCELLED);
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  assert_in_range(cancel.reports, 2, 2);
  assert_near((double)(now.tv_sec - cancel.when.tv_sec) + 1e-9 * (double)(now.tv_nsec - cancel.when.tv_nsec), 0,
              2 * 0.5);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
}

/* Some seconds of erosion. */
static neph_result make_large_ridges(test_fixture *f, const neph_terrain_desc *desc) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 2049;
  neph_terrain *terrain = (neph_terrain *)f;
  const neph_result result = neph_terrain_create_ridges(f->context, &ridges, desc, &terrain);
  assert_null(terrain);
  return result;
}

/* A second or so of vertices, and of Embree's tree. */
static neph_result load_large_tile(test_fixture *f, const neph_terrain_desc *desc) {
  char *path = test_path(f->folder, "N44W072.hgt");
  if (access(path, R_OK)) free(test_hgt_write(f->folder, "N44W072.hgt", 3601, stand_high));
  neph_terrain *terrain = (neph_terrain *)f;
  const neph_result result = neph_terrain_load(f->context, path, desc, &terrain);
  assert_null(terrain);
  free(path);
  return result;
}

enum { PICTURE_EDGE = 4096 };

/* Heights that no codec makes smaller, so that reading them takes half a second. */
static neph_image *make_rough_picture(test_fixture *f) {
  static const char *const name = "Y";
  neph_image *image;
  assert_int_equal(neph_image_create(f->context, PICTURE_EDGE, PICTURE_EDGE, 1, &name, &image), NEPH_OK);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  float *values = neph_image_get_channel(image, name);
  for (size_t i = 0; i < (size_t)PICTURE_EDGE * PICTURE_EDGE; i++) values[i] = np_random_float(&random);
  return image;
}

static neph_result load_picture(test_fixture *f, char *path, const neph_terrain_desc *desc) {
  neph_terrain *terrain = (neph_terrain *)f;
  const neph_result result = neph_terrain_load(f->context, path, desc, &terrain);
  assert_null(terrain);
  free(path);
  return result;
}

static neph_result load_large_exr(test_fixture *f, const neph_terrain_desc *desc) {
  char *path = test_path(f->folder, "heights.exr");
  neph_image *image = make_rough_picture(f);
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  return load_picture(f, path, desc);
}

static neph_result load_large_png(test_fixture *f, const neph_terrain_desc *desc) {
  char *path = test_path(f->folder, "heights.png");
  neph_image *image = make_rough_picture(f);
  png_image picture = {.version = PNG_IMAGE_VERSION,
                       .width = PICTURE_EDGE,
                       .height = PICTURE_EDGE,
                       .format = PNG_FORMAT_LINEAR_Y,
                       .flags = PNG_IMAGE_FLAG_FAST};
  assert_true(png_image_write_to_file(&picture, path, 0, neph_image_get_channel(image, "Y"), 2 * PICTURE_EDGE, NULL));
  neph_image_destroy(image);
  return load_picture(f, path, desc);
}

static void every_stage_can_be_cancelled(void **state) {
  assert_cancelled(*state, "reading heights", load_large_exr);
  assert_cancelled(*state, "reading heights", load_large_png);
  assert_cancelled(*state, "raising ridges", make_large_ridges);
  assert_cancelled(*state, "placing terrain", load_large_tile);
  assert_cancelled(*state, "building terrain", load_large_tile);
}

static neph_result make_and_release(neph_context *context, void *user) {
  (void)user;
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 9;
  neph_terrain_desc desc = describe_fading();
  desc.width_m = 3000;
  neph_terrain *terrain = NULL;
  neph_result result = neph_terrain_create_ridges(context, &ridges, &desc, &terrain);
  neph_terrain_release(terrain);
  return result;
}

static neph_result load_and_release(neph_context *context, void *path) {
  neph_terrain *terrain = NULL;
  neph_result result = neph_terrain_load(context, path, NULL, &terrain);
  neph_terrain_release(terrain);
  return result;
}

static neph_result describe_and_free(neph_context *context, void *path) {
  char *text = NULL;
  neph_result result = neph_terrain_describe_file(context, path, NEPH_TEXT_PLAIN, &text);
  neph_text_destroy(context, text);
  return result;
}

static int slope_with_hole(unsigned column, unsigned row) { return column - 600 < 3 && row == 7 ? -32768 : 5; }

static void failed_allocations_leave_nothing_behind(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N44W072.hgt", 1201, slope_with_hole);
  assert_survives_failed_allocations(make_and_release, NULL);
  assert_survives_failed_allocations(load_and_release, path);
  assert_survives_failed_allocations(describe_and_free, path);
  free(path);
}

/* The terrain outlives the context's owner, and the first of two references. */
static void references_keep_a_terrain(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  neph_terrain *terrain = make_ridges(context, 33), *second = neph_terrain_retain(terrain);
  neph_context_destroy(context);
  neph_terrain_release(terrain);
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(second, (np_dvec3){0, 0, 5000}, np_vec3_make(0, 0, -1), INFINITY, &hit));
  neph_terrain_release(second);
  neph_terrain_release(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(the_rim_meets_the_sphere),
      TEST(the_place_is_the_middle_or_as_given),
      TEST(ridges_take_the_place_given),
      TEST(mount_washington_is_where_it_is),
      TEST(an_island_reaches_below_the_sea),
      TEST(bad_descriptions_are_refused),
      TEST(bad_ridges_are_refused),
      TEST(every_stage_can_be_cancelled),
      TEST(failed_allocations_leave_nothing_behind),
      TEST(references_keep_a_terrain),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
