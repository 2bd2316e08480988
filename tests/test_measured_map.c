/* SPDX-License-Identifier: Apache-2.0 */
/* Measured fields of clouds: columns of a bake have the optical depth, the coverage and the tops of their pixels. */
#include "test_clouds.h"

#include "cloud/measured_map.h"
#include "core/random.h"

enum { PIXELS = 10, ALL = PIXELS * PIXELS, EDGE_M = 500 };

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

/* A field of 10 × 10 pixels of 500 m around the origin, north up. */
typedef struct memory_map {
  float depths[ALL], tops_m[ALL];
  bool has_tops;
  double nodes[8], threshold;
  neph_cloud_measurement_source source;
} memory_map;

static neph_cloud_raster make_raster(const memory_map *map, const float *values) {
  return (neph_cloud_raster){.width = PIXELS,
                             .height = PIXELS,
                             .values = values,
                             .min_m = {-0.5 * PIXELS * EDGE_M, -0.5 * PIXELS * EDGE_M},
                             .max_m = {0.5 * PIXELS * EDGE_M, 0.5 * PIXELS * EDGE_M},
                             .node_count = {2, 2},
                             .node_pixels = map->nodes};
}

static neph_result load_map(void *user, neph_context *context, neph_cloud_measurement *out) {
  const memory_map *map = user;
  (void)context;
  *out = (neph_cloud_measurement){.optical_depth = make_raster(map, map->depths), .threshold = map->threshold};
  if (map->has_tops) out->top_m = make_raster(map, map->tops_m);
  return NEPH_OK;
}

/* Depths from 2 to 40, and a tenth of the pixels clear. */
static void draw_map(memory_map *map, uint64_t seed) {
  const double low = -0.5, high = PIXELS - 0.5;
  *map = (memory_map){.nodes = {low, high, high, high, low, low, high, low}, .threshold = 0.3};
  map->source = (neph_cloud_measurement_source){.name = "memory", .id = "memory", .load = load_map, .user = map};
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  for (int i = 0; i < ALL; i++) {
    const double u = np_random_double(&random);
    map->depths[i] = u < 0.1 ? 0.0f : (float)(2.0 * pow(20.0, (u - 0.1) / 0.9));
    map->tops_m[i] = (float)(1100.0 + 200.0 * np_random_double(&random));
  }
}

static neph_cloud_desc measured_field(const test_fixture *f, const memory_map *map, neph_cloud_model model) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "stratocumulus", &desc), NEPH_OK);
  desc.model = model;
  desc.seed = 5;
  desc.extent_m[0] = desc.extent_m[1] = PIXELS * EDGE_M;
  desc.voxel_m = 50;
  desc.measurement = &map->source;
  return desc;
}

/* Sums of the columns of a bake in each pixel. */
typedef struct pixel_sums {
  double depth[ALL], covered[ALL], top_m[ALL];
} pixel_sums;

static void gather_pixels(const np_sparse_grid *grid, const neph_cloud_desc *desc, pixel_sums *out) {
  const int side = (int)round(desc->extent_m[0] / desc->voxel_m), across = EDGE_M / (int)desc->voxel_m;
  double *depths = calloc((size_t)(side * side), sizeof *depths), *tops = calloc((size_t)(side * side), sizeof *tops);
  for (size_t l = 0; l < grid->leaf_count; l++) {
    const np_leaf *leaf = &grid->leaves[l];
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8, k = leaf->origin[2] + n % 8;
      if (i >= side || j >= side) continue;
      depths[j * side + i] += (double)leaf->values[n] * desc->voxel_m;
      if (leaf->values[n] > 0.1f * (float)desc->extinction_per_m)
        tops[j * side + i] = fmax(tops[j * side + i], (k + 1) * desc->voxel_m);
    }
  }
  memset(out, 0, sizeof *out);
  for (int c = 0; c < side * side; c++) {
    const int pixel = (PIXELS - 1 - c / side / across) * PIXELS + c % side / across;
    out->depth[pixel] += depths[c] / (across * across);
    out->covered[pixel] += (depths[c] > 0.3) / (double)(across * across);
    out->top_m[pixel] += tops[c] / (across * across);
  }
  free(depths);
  free(tops);
}

static void bake_pixels(const test_fixture *f, const neph_cloud_desc *desc, pixel_sums *out) {
  np_sparse_grid grid = test_bake(f->context, desc);
  gather_pixels(&grid, desc, out);
  np_sparse_grid_clear(&grid);
}

/* The depth of a pixel is exact but for rounding: each voxel is a float. A model that has too little cloud in a pixel
 * fills it with a profile whose sum over four voxels or more is off by at most 1/(2·4²) of its mean. */
static void every_model_has_the_depth_of_each_pixel(void **state) {
  test_fixture *f = *state;
  for (int model = 0; np_cloud_kind_get((neph_cloud_model)model); model++) {
    memory_map map;
    pixel_sums sums;
    draw_map(&map, 7);
    const neph_cloud_desc desc = measured_field(f, &map, (neph_cloud_model)model);
    bake_pixels(f, &desc, &sums);
    for (int i = 0; i < ALL; i++) {
      if (!(fabs(sums.depth[i] - (double)map.depths[i]) <= 0.02 * (double)map.depths[i]))
        fail_msg("model %d, pixel %d: optical depth %g, must be %g", model, i, sums.depth[i], (double)map.depths[i]);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(every_model_has_the_depth_of_each_pixel)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
