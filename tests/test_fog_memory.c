/* SPDX-License-Identifier: Apache-2.0 */
/* A fog of 1024³ voxels, a fifth of them active in leaves that are scattered, so that nearly every window of bricks is
 * mixed: written, loaded and rendered in a limited memory. Long: it takes minutes and gigabytes. */
#include "test_support.h"

#include <stdlib.h>
#include <sys/resource.h>

#include <nephos/nephos.h>

#include "volume/volume_private.h"

enum { EDGE_LEAVES = 128, SHARE = 5 };

static const double memory_max_bytes = 24e9;

static int set_up(void **state) { return test_set_up(state, 2, "fog.vdb"); }

static uint32_t mix(uint32_t n) {
  n = (n ^ n >> 16) * 0x7feb352du;
  n = (n ^ n >> 15) * 0x846ca68bu;
  return n ^ n >> 16;
}

/* One leaf in five by chance, with values of its own. */
static void fill(np_sparse_grid *grid) {
  for (uint32_t n = 0; n < EDGE_LEAVES * EDGE_LEAVES * EDGE_LEAVES; n++) {
    const int32_t x = (int32_t)(n / EDGE_LEAVES / EDGE_LEAVES), y = (int32_t)(n / EDGE_LEAVES % EDGE_LEAVES);
    if (mix(n) % SHARE) continue;
    np_leaf *leaf =
        np_sparse_grid_add_leaf(grid, (const int32_t[3]){8 * x, 8 * y, 8 * (int32_t)(n % EDGE_LEAVES)});
    assert_non_null(leaf);
    for (uint32_t i = 0; i < NP_LEAF_SIZE; i++) leaf->values[i] = 0.5f + (float)(mix(n * 512 + i) & 255) / 512.0f;
    memset(leaf->active, 0xff, sizeof leaf->active);
  }
}

static void write_fog(const test_fixture *f) {
  np_sparse_grid grid;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &grid), NEPH_OK);
  fill(&grid);
  const double share = (double)np_sparse_grid_count_active(&grid) / (1024.0 * 1024.0 * 1024.0);
  assert_near(share, 0.2, 0.002); /* three deviations of two million draws are 0.0008 */
  const np_vdb_write_grid output = {.grid = &grid, .is_half = true};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

static double get_peak_bytes(void) {
  struct rusage usage;
  assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
  return 1024.0 * (double)usage.ru_maxrss;
}

static void a_large_fog_keeps_within_memory(void **state) {
  static const char text[] =
      "{camera: {position: [512, -2 km, 512], look_at: [512, 0, 512], fov: 40 deg, resolution: [4, 4]},"
      " atmosphere: none, environment: {radiance: 1}, sun: {irradiance: 0},"
      " clouds: [{name: fog, vdb: fog.vdb, optical_depth: 20, albedo: 0}],"
      " render: {integrator: path, samples: 4}}";
  const test_fixture *f = *state;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_scene *scene;
  neph_image *image;
  double mean;
  write_fog(f);
  print_message("written: peak %.2f GB\n", 1e-9 * get_peak_bytes());
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  assert_int_equal(sscanf(neph_image_get_attribute(image, "nephos:mean"), "%lf", &mean), 1);
  print_message("rendered: mean %g, peak %.2f GB\n", mean, 1e-9 * get_peak_bytes());
  assert_true(mean > 0.0 && mean < 1.0); /* the fog hides a part of its surroundings, of radiance 1 */
  assert_true(get_peak_bytes() < memory_max_bytes);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_large_fog_keeps_within_memory, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
