/* SPDX-License-Identifier: Apache-2.0 */
/* Files of a box of cloud, or a soft ball, with its velocity, for tests of motion. Voxels are 1 m wide. */
#ifndef NP_TEST_VELOCITY_FILES_H
#define NP_TEST_VELOCITY_FILES_H

#include "test_support.h"

#include "volume/volume_private.h"

enum { TEST_VELOCITY_EDGE = 48 }; /* edge of the lattice, from −24 to 23 */

typedef struct test_velocity {
  const char *names[3]; /* grid names; the first alone: a vector */
  double radius;        /* radius in voxels of the ball, which is 1 in its middle and 0 at its rim; 0: a box … */
  int32_t half;         /* … from −half to half */
  float value;
  float at[3]; /* m/s */
  float shear; /* 1/s: more along x for each voxel of y */
} test_velocity;

static inline float test_velocity_get_density(const test_velocity *v, const int32_t at[3]) {
  const double r2 = ((double)at[0] * at[0] + (double)at[1] * at[1] + (double)at[2] * at[2]) / (v->radius * v->radius);
  if (v->radius > 0.0) return r2 < 1.0 ? v->value * (float)(1.0 - r2) : 0.0f;
  return abs(at[0]) <= v->half && abs(at[1]) <= v->half && abs(at[2]) <= v->half ? v->value : 0.0f;
}

/* Density in the first grid, the components of the velocity, which is active where that is not 0, in the others. */
static inline void test_velocity_make(neph_context *context, const test_velocity *v, np_sparse_grid grids[4]) {
  for (int g = 0; g < 4; g++) {
    const char *name = g == 0 ? "density" : v->names[1] ? v->names[g - 1] : v->names[0] ? v->names[0] : "none";
    assert_int_equal(np_sparse_grid_init(context, name, &grids[g]), NEPH_OK);
    grids[g].index_to_world = np_affine_identity();
    int32_t o[3];
    for (o[0] = -TEST_VELOCITY_EDGE / 2; o[0] < TEST_VELOCITY_EDGE / 2; o[0] += NP_LEAF_EDGE)
      for (o[1] = -TEST_VELOCITY_EDGE / 2; o[1] < TEST_VELOCITY_EDGE / 2; o[1] += NP_LEAF_EDGE)
        for (o[2] = -TEST_VELOCITY_EDGE / 2; o[2] < TEST_VELOCITY_EDGE / 2; o[2] += NP_LEAF_EDGE) {
          np_leaf *leaf = np_sparse_grid_add_leaf(&grids[g], o);
          assert_non_null(leaf);
          for (int n = 0; n < NP_LEAF_SIZE; n++) {
            const int32_t at[3] = {o[0] + (n >> 6), o[1] + (n >> 3 & 7), o[2] + (n & 7)};
            const float density = test_velocity_get_density(v, at);
            if (density == 0.0f) continue;
            leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
            leaf->values[n] = g == 0 ? density : v->at[g - 1] + (g == 1 ? v->shear * (float)at[1] : 0.0f);
          }
        }
  }
}

static inline void test_velocity_write(neph_context *context, const char *path, const test_velocity *v) {
  np_sparse_grid grids[4];
  test_velocity_make(context, v, grids);
  np_vdb_write_grid outputs[4] = {{.grid = &grids[0]}};
  size_t count = 1;
  if (v->names[0] && !v->names[1])
    outputs[count++] = (np_vdb_write_grid){.grid = &grids[1], .y = &grids[2], .z = &grids[3]};
  for (int a = 0; a < 3 && v->names[1]; a++) outputs[count++] = (np_vdb_write_grid){.grid = &grids[1 + a]};
  assert_int_equal(np_volume_save_grids(context, path, outputs, count, NULL), NEPH_OK);
  for (int g = 0; g < 4; g++) np_sparse_grid_clear(&grids[g]);
}

#endif
