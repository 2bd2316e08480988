/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of files within a limit on memory: in halves, at half the resolution, or refused; by both integrators. */
#include "test_support.h"

#include <stdlib.h>
#include <string.h>

#include <nephos/cloud.h>
#include <nephos/nephos.h>

#include "volume/sparse_grid.h"

/* Without air, and few scatterings: whatever is left is the cloud's. */
static const char scene_text[] =
    "{camera: {position: [0, -5 km, 1.5 km], look_at: [0, 0, 1.5 km], fov: 50 deg, resolution: [24, 14]},"
    " atmosphere: none, environment: {radiance: 1, hemisphere: upper}, sun: {irradiance: 0}, clouds:"
    " [{name: import, vdb: cloud.vdb, precision: float, extinction: 0.02 1/m, albedo: 0.9}], render: {samples: 4}}";

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

static void bake_file(const test_fixture *f) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  cloud.extent_m[0] = cloud.extent_m[1] = 2500.0;
  cloud.voxel_m = 50.0;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &bake, "density", f->path), NEPH_OK);
}

static neph_scene *load(const test_fixture *f, neph_integrator integrator) {
  neph_scene *scene;
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, scene_text, path, &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator == NEPH_INTEGRATOR_PATH ? "path" : "march"),
                   NEPH_OK);
  free(path);
  return scene;
}

typedef struct rendered {
  neph_result result;
  double mean;
  char savings[240];
} rendered;

static rendered render(const test_fixture *f, neph_scene *scene, uint64_t bytes) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  rendered out = {.mean = 0.0};
  (void)f;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.memory_max_bytes = bytes;
  out.result = neph_render_image(scene, &desc, &image);
  if (out.result) return out;
  const char *savings = neph_image_get_attribute(image, "nephos:memorySavings");
  (void)snprintf(out.savings, sizeof out.savings, "%s", savings ? savings : "");
  assert_int_equal(sscanf(neph_image_get_attribute(image, "nephos:mean"), "%lf", &out.mean), 1);
  neph_image_destroy(image);
  return out;
}

static neph_memory_estimate estimate(neph_scene *scene) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_memory_estimate e = NEPH_MEMORY_ESTIMATE_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(neph_render_estimate_memory(scene, &desc, &e), NEPH_OK);
  return e;
}

/* Floats take twice the bytes of halves; voxels twice as long a fifth of that. What halves change is 2^-11; a coarser
 * voxel's bias is 5 % of a pixel, and of the mean less; paths add a noise of 2 %. */
static void imports_keep_within_memory(void **state) {
  test_fixture *f = *state;
  bake_file(f);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, i);
    const neph_memory_estimate e = estimate(scene);
    const double base = (double)(e.total_bytes - e.volume_bytes), volume = (double)e.volume_bytes;
    const double light = i == NEPH_INTEGRATOR_MARCH ? (double)e.light_bytes : 0.0;
    /* Coarser cells need 1 MB: with halves there is less, with longer voxels more. */
    const double cells = i == NEPH_INTEGRATOR_MARCH ? 1e6 : 0.0;
    const rendered whole = render(f, scene, NEPH_MEMORY_UNLIMITED);
    const rendered halves = render(f, scene, (uint64_t)(base + 0.75 * volume));
    const rendered coarse = render(f, scene, (uint64_t)(base - light + cells + 0.4 * volume));
    test_log_clear(&f->log);
    const rendered refused = render(f, scene, (uint64_t)(base - light));
    print_message("means %g, %g, %g: %s\n", whole.mean, halves.mean, coarse.mean, coarse.savings);
    assert_string_equal(whole.savings, "");
    assert_string_equal(halves.savings, "volumes are kept in halves instead of floats");
    assert_non_null(
        strstr(coarse.savings, "volumes are kept in halves instead of floats, and voxels of files are twice"));
    assert_int_equal(refused.result, NEPH_ERROR_LIMIT);
    assert_non_null(strstr(f->log.text, "the render needs about"));
    assert_near_relative(halves.mean, whole.mean, i == NEPH_INTEGRATOR_PATH ? 0.02 : 1e-3);
    assert_near_relative(coarse.mean, whole.mean, 0.05);
    assert_string_equal(render(f, scene, (uint64_t)(base - light + cells + 0.4 * volume)).savings, coarse.savings);
    neph_scene_destroy(scene);
  }
}

/* The mean, the sum times the voxels' volume, and the middle of what is active stay, in a lattice that is turned and
 * sheared, with tiles of each size. */
static void half_resolution_keeps_sums(void **state) {
  const test_fixture *f = *state;
  np_sparse_grid fine, coarse;
  assert_int_equal(np_sparse_grid_init(f->context, "density", &fine), NEPH_OK);
  fine.index_to_world = (np_affine){{{2, 1, 0, 5}, {-1, 2, 0.5, 7}, {0, 0, 3, -2}}};
  np_leaf *leaf = np_sparse_grid_add_leaf(&fine, (const int32_t[3]){-8, 0, 8});
  double sum = 0.0, coarse_sum = 0.0;
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    leaf->values[n] = (float)(n % 7);
    sum += n % 7;
    leaf->active[n / 64] |= UINT64_C(1) << (n % 64);
  }
  const int32_t origins[3][3] = {{16, 0, 0}, {128, 0, -128}, {4096, -4096, 0}}, edges[3] = {8, 128, 4096};
  for (int t = 0; t < 3; t++) {
    assert_non_null(np_sparse_grid_add_tile(&fine, origins[t], edges[t], 0.5f, true));
    sum += 0.5 * pow(edges[t], 3.0);
  }
  assert_int_equal(np_sparse_grid_halve(&fine, "density", &coarse), NEPH_OK);
  for (size_t i = 0; i < coarse.leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) coarse_sum += (double)coarse.leaves[i].values[n];
  for (size_t i = 0; i < coarse.tile_count; i++)
    coarse_sum += (double)coarse.tiles[i].value * pow(coarse.tiles[i].edge, 3.0);
  assert_near_relative(8.0 * coarse_sum, sum, 1e-12);
  assert_int_equal(coarse.tile_count, 512 + 4096);
  const np_dvec3 of_eight = np_affine_point(&fine.index_to_world, np_dvec3_make(0.5, 0.5, 0.5));
  const np_dvec3 of_one = np_affine_point(&coarse.index_to_world, np_dvec3_make(0, 0, 0));
  assert_true(np_dvec3_length(np_dvec3_subtract(of_eight, of_one)) < 1e-12);
  np_sparse_grid_clear(&fine);
  np_sparse_grid_clear(&coarse);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(imports_keep_within_memory, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(half_resolution_keeps_sums, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
