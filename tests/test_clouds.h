/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds for the tests of the cloud module, baked, and looked at column by column. */
#ifndef NP_TEST_CLOUDS_H
#define NP_TEST_CLOUDS_H

#include "test_support.h"

#include <stdlib.h>

#include <nephos/cloud.h>

#include "cloud/bake_grid.h"
#include "cloud/cloud_build.h"
#include "cloud/cloud_column.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_grain.h"
#include "cloud/cloud_kinds.h"
#include "cloud/presets.h"
#include "core/text.h"
#include "volume/volume_private.h"

enum { TEST_PRESET_NAME_MAX = 64 };

/* The name of a preset of the table; false: it has none of that number. */
static inline bool test_get_preset(neph_context *context, size_t index, char out[TEST_PRESET_NAME_MAX]) {
  np_text names = {.context = context};
  np_cloud_list_presets(&names);
  const char *name = np_text_get(&names);
  for (size_t i = 0; i < index && name; i++) name = (name = strchr(name, ',')) ? name + strlen(", ") : NULL;
  if (name) snprintf(out, TEST_PRESET_NAME_MAX, "%.*s", (int)strcspn(name, ","), name);
  const bool is_there = name != NULL;
  assert_int_equal(np_text_end(&names, NEPH_OK), NEPH_OK);
  return is_there;
}

/* A field of 6 km with 40 m voxels: a fifth of a second. */
static inline neph_cloud_desc test_small_field(uint64_t seed) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.seed = seed;
  desc.extent_m[0] = 6000;
  desc.extent_m[1] = 5000;
  desc.voxel_m = 40;
  return desc;
}

static inline np_sparse_grid test_bake(neph_context *context, const neph_cloud_desc *desc) {
  const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid grid;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_cloud_bake_grid(context, desc, &bake_desc, "density", &monitor, &grid), NEPH_OK);
  return grid;
}

/* ---- What is in a grid, column by column ---- */

typedef struct test_columns {
  int size[2];
  int32_t *lowest; /* index of the lowest active voxel; INT32_MAX: clear */
  double covered, optical_depth;
} test_columns;

static inline void test_visit_leaf(const np_leaf *leaf, double voxel_m, test_columns *c) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const bool has_cloud = leaf->values[n] > 0;
    if ((leaf->active[n / 64] >> (n % 64) & 1) != has_cloud) fail_msg("voxel %d: active, or cloud, not both", n);
    if (!has_cloud) continue;
    int i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8;
    if (i >= c->size[0] || j >= c->size[1]) continue; /* the last leaf may reach beyond the field; counted as border */
    int32_t *lowest = &c->lowest[i * c->size[1] + j], k = leaf->origin[2] + n % 8;
    c->optical_depth += (double)leaf->values[n] * voxel_m;
    if (k < *lowest) *lowest = k;
  }
}

static inline test_columns test_gather_columns(const np_sparse_grid *grid, const neph_cloud_desc *desc) {
  test_columns c = {
      .size = {(int)round(desc->extent_m[0] / desc->voxel_m), (int)round(desc->extent_m[1] / desc->voxel_m)}};
  const int count = c.size[0] * c.size[1];
  c.lowest = malloc((size_t)count * sizeof *c.lowest);
  for (int i = 0; i < count; i++) c.lowest[i] = INT32_MAX;
  for (size_t i = 0; i < grid->leaf_count; i++) test_visit_leaf(&grid->leaves[i], desc->voxel_m, &c);
  for (int i = 0; i < count; i++) c.covered += c.lowest[i] < INT32_MAX;
  c.covered /= count;
  c.optical_depth /= count;
  return c;
}

static inline double test_compute_covered(neph_context *context, const neph_cloud_desc *desc) {
  np_sparse_grid grid = test_bake(context, desc);
  test_columns c = test_gather_columns(&grid, desc);
  free(c.lowest);
  np_sparse_grid_clear(&grid);
  return c.covered;
}

/* Voxels with cloud at these indices of height. */
static inline double test_count_voxels(const np_sparse_grid *grid, int32_t from, int32_t to) {
  uint64_t count = 0;
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      int32_t k = grid->leaves[l].origin[2] + n % 8;
      count += grid->leaves[l].values[n] > 0 && k >= from && k < to;
    }
  return (double)count;
}

/* Hash of a cloud's bake in a context that has its files; it has `leaf_min` leaves at least. */
static inline void test_hash_bake(neph_context *context, const neph_cloud_desc *desc, size_t leaf_min, char out[33]) {
  np_sparse_grid grid = test_bake(context, desc);
  assert_true(grid.leaf_count >= leaf_min);
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&grid}, 1, false, out), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

/* Checks the hash of a bake with a number of threads and an instruction set. */
static inline void test_check_hash(unsigned thread_count, neph_isa isa, const neph_cloud_desc *desc,
                                   const char *expected) {
  neph_context *context = NULL;
  neph_context_desc context_desc = NEPH_CONTEXT_DESC_DEFAULT;
  char hash[33];
  context_desc.thread_count = thread_count;
  context_desc.isa_max = isa;
  assert_int_equal(neph_context_create(&context_desc, &context), NEPH_OK);
  test_hash_bake(context, desc, 0, hash);
  assert_string_equal(hash, expected);
  neph_context_destroy(context);
}

/* A cloud is baked to the same bits by one thread and by `thread_count`, at each level. */
static inline void test_check_bits(unsigned thread_count, const neph_cloud_desc *desc, size_t leaf_min) {
  neph_context *context = test_context_create(1, NULL);
  char hash[33];
  test_hash_bake(context, desc, leaf_min, hash);
  neph_context_destroy(context);
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= NEPH_ISA_X86_64_V4; isa++) test_check_hash(thread_count, isa, desc, hash);
}

#endif
