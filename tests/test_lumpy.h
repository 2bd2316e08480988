/* SPDX-License-Identifier: Apache-2.0 */
/* A lumpy ball of cloud on cells of several kinds, for the tests of the solved multiple scattering. */
#ifndef NP_TEST_LUMPY_H
#define NP_TEST_LUMPY_H

#include "test_world.h"
#include "transport/scattering_field_private.h"

static inline void test_lumpy_create(test_world *w, unsigned threads) {
  test_world_create(w, threads, test_cloud_make_on_axes(test_lumpy_ball, 0.0));
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
}

static inline void test_lumpy_solve(test_world *w) { assert_int_equal(test_world_solve(w), NEPH_OK); }

static inline double test_lumpy_march(const test_world *w, np_dvec3 origin, np_vec3 direction, np_random *random) {
  const np_camera_ray ray = {.origin = origin, .direction = direction, .jitter = np_random_float(random)};
  np_integrator_sample sample;
  test_world_march(w, &ray, random, &sample);
  return test_sum_components(&sample, 1);
}

/* Cells of one voxel, of which light is resolved into seven degrees, and iterated on those twice as wide. */
static inline void test_lumpy_create_fine(test_world *w, unsigned threads) {
  test_lumpy_create(w, threads);
  w->desc.cells.cell_count_cheap = 0;
  w->desc.cells.cell_count_fine = 1000000;
  w->desc.work_max = 0.0;
}

/* Cells of two voxels, solved to the least degree and resolved into seven, under a sun overhead. */
static inline void test_lumpy_create_resolved(test_world *w) {
  test_lumpy_create(w, 2);
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
  w->desc.cells.cell_count_cheap = 0;
  w->desc.work_max = 0.0;
}

#endif
