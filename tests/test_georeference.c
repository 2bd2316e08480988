/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in the coordinate system of the terrain's raster stand on it: places that are known, and files that are none
 * of that system. */
#include "test_rasters.h"

#include <nephos/nephos.h>

#include "plan/georeference.h"
#include "terrain/raster_lattice.h"
#include "volume/volume_private.h"

static int set_up_cloud(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

/* Forty samples a hundred metres apart, 4 km, at easting 400 km of zone 11, where its grid is turned by 0.6° against
 * north, and 34° N. */
enum { SIDE = 41 };
static const double east_m = 400000.0, north_m = 3762100.0;

static char *write_raster(const test_fixture *f) {
  char samples[SIDE * SIDE * 4 + 1], *at = samples;
  for (int n = 0; n < SIDE * SIDE; n++) at += snprintf(at, 5, "100 ");
  return write_text(f, "ground.asc",
                    "ncols %d\nnrows %d\nxllcenter %.3f\nyllcenter %.3f\ncellsize 100\nNODATA_value -9999\n%s\n", SIDE,
                    SIDE, east_m, north_m, samples);
}

static void write_cloud(const test_fixture *f, double x, double y, double z) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  const double at[3] = {x, y, z};
  for (int a = 0; a < 3; a++) grid.index_to_world.m[a][a] = 20.0, grid.index_to_world.m[a][3] = at[a];
  np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){0, 0, 0});
  memset(leaf->active, 0xff, sizeof leaf->active);
  for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = 0.01f;
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

static neph_scene *load_scene(const test_fixture *f, const char *raster, const char *keys) {
  char text[2048];
  neph_scene *scene = NULL;
  (void)snprintf(text, sizeof text,
                 "version: 1\nsun: {elevation: 30 deg}\nrender: {samples: 1, multiple_scattering: none}\n"
                 "camera: {position: [0, -3 km, 1 km], look_at: [0, 0, 800 m], resolution: [64, 36]}\n"
                 "clouds: [{name: u, vdb: \"%s\", extinction: 1%s%s}]\n"
                 "terrain: {heightfield: \"%s\", crs: \"EPSG:32611\"}\n",
                 f->path, *keys ? ", " : "", keys, raster);
  assert_int_equal(neph_scene_load_text(f->context, text, "u.yaml", &scene), NEPH_OK);
  return scene;
}

/* Box of the cloud in the world, as it is placed; false: not by the raster. */
static bool place(const test_fixture *f, neph_scene *scene, np_dvec3 *out_low, np_dvec3 *out_high) {
  neph_volume *volume = NULL;
  np_georeference georeference;
  np_affine file_to_world = np_affine_identity();
  const neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  double low[3], high[3];
  assert_int_equal(neph_volume_load(f->context, f->path, &desc, &volume), NEPH_OK);
  assert_int_equal(np_georeference_apply(scene, &scene->clouds[0], volume, &file_to_world, &georeference), NEPH_OK);
  const np_affine to_world = np_affine_compose(&file_to_world, &volume->index_to_world);
  np_volume_bound_box(&to_world, volume->active_min, volume->active_max, low, high);
  *out_low = np_dvec3_make(low[0], low[1], low[2]), *out_high = np_dvec3_make(high[0], high[1], high[2]);
  neph_volume_release(volume);
  return georeference.is_applied;
}

/* The middle of the raster is the world's origin. A point 500 m east and 300 m north of it by the grid is turned by
 * its convergence, (λ − λ₀)·sin φ = −1.061° × 0.559: grid north is 0.593° west of north, and lengths are 1/0.99972
 * times as far. */
static void a_cloud_of_the_system_stands_on_the_ground(void **state) {
  test_fixture *f = *state;
  char *raster = write_raster(f);
  const double middle = 2000.0, half = 70.0;
  write_cloud(f, east_m + middle + 500.0 - half, north_m + middle + 300.0 - half, 900.0 - half);
  neph_scene *scene = load_scene(f, raster, "");
  np_dvec3 low, high;
  assert_true(place(f, scene, &low, &high));
  const double turn = 0.5934 * 0.017453292519943295, scale = 1.0 / 0.99972;
  const double x = 0.5 * (low.x + high.x), y = 0.5 * (low.y + high.y), z = 0.5 * (low.z + high.z);
  print_message("at (%.3f, %.3f, %.3f)\n", x, y, z);
  assert_near(x, scale * (500.0 * cos(turn) - 300.0 * sin(turn)), 0.1); /* a hundredth of a degree, at 580 m */
  assert_near(y, scale * (500.0 * sin(turn) + 300.0 * cos(turn)), 0.1);
  assert_near(z, 900.0, 0.05); /* less the bend of the planet, 27 mm */
  neph_scene_destroy(scene);
  free(raster);
}

static void it_is_rendered_there_with_a_warning(void **state) {
  test_fixture *f = *state;
  char *raster = write_raster(f);
  write_cloud(f, east_m + 2000.0, north_m + 2000.0, 800.0);
  neph_scene *scene = load_scene(f, raster, "");
  neph_image *image = NULL;
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  assert_one_warning(&f->log, "cloud u: stands where its file's coordinates are in the system of the terrain's raster",
                     "UTM zone 11N");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  free(raster);
}

/* A position, coordinates near the origin or beyond the raster, and another terrain. */
static void others_stay_where_they_are(void **state) {
  test_fixture *f = *state;
  char *raster = write_raster(f);
  np_dvec3 low, high;
  write_cloud(f, east_m + 2000.0, north_m + 2000.0, 800.0);
  neph_scene *scene = load_scene(f, raster, "position: [0, 0, 0]");
  assert_false(place(f, scene, &low, &high));
  neph_scene_destroy(scene);
  const double places[][2] = {{0.0, 0.0}, {40000.0, 0.0}, {east_m + 7000.0, north_m}, {east_m, north_m - 3000.0}};
  for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
    write_cloud(f, places[i][0], places[i][1], 800.0);
    scene = load_scene(f, raster, "");
    assert_false(place(f, scene, &low, &high));
    neph_scene_destroy(scene);
  }
  free(raster);
}

/* The same cloud in a zone beside: thousands of kilometres away, which is said. */
static void a_cloud_of_another_system_is_warned_of(void **state) {
  test_fixture *f = *state;
  char *raster = write_raster(f);
  write_cloud(f, east_m + 300000.0, north_m, 800.0);
  neph_scene *scene = load_scene(f, raster, "");
  neph_image *image = NULL;
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  if (!strstr(f->log.text, "km from the terrain, which is ")) fail_msg("%s", f->log.text);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  free(raster);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_cloud_of_the_system_stands_on_the_ground, set_up_cloud, test_tear_down),
      cmocka_unit_test_setup_teardown(it_is_rendered_there_with_a_warning, set_up_cloud, test_tear_down),
      cmocka_unit_test_setup_teardown(others_stay_where_they_are, set_up_cloud, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_of_another_system_is_warned_of, set_up_cloud, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
