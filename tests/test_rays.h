/* SPDX-License-Identifier: Apache-2.0 */
/* Rays through a cloud at the origin, what integrators make of them, and means of that. */
#ifndef NP_TEST_RAYS_H
#define NP_TEST_RAYS_H

#include "test_support.h"

#include "integrate/integrator.h"
#include "test_sum.h"

/* No limit to scattering, and steps finer than a picture needs. */
static inline np_integrator_settings test_integrator_settings(void) {
  return (np_integrator_settings){.scattering_max = UINT32_MAX,
                                  .approximation.gain = 1.0,
                                  .tolerance = 0.01f,
                                  .step_voxels = 4.0f,
                                  .transmittance_end = 1e-4f};
}

static inline const np_integrator_kernels *test_integrators(const neph_context *context) {
  return np_integrator_get_kernels(neph_context_get_isa(context));
}

/* A ray towards +y through a random point of the middle plane. */
static inline np_camera_ray test_random_ray(np_random *random) {
  const double x = 20.0 * (np_random_double(random) - 0.5), z = 20.0 * (np_random_double(random) - 0.5);
  return (np_camera_ray){.origin = {x, -100.0, z}, .direction = {0, 1, 0}, .jitter = np_random_float(random)};
}

static inline double test_sum_components(const np_integrator_sample *sample, int band) {
  double sum = 0.0;
  for (int c = 0; c < NP_COMPONENT_COUNT; c++) sum += (double)sample->component[c].band[band];
  return sum;
}

/* ---- Means ---- */

/* A sum of random numbers, of which mean and standard error are wanted. */
typedef struct test_tally {
  test_sum value, square;
  int count;
} test_tally;

static inline void test_tally_add(test_tally *t, double x) {
  test_sum_add(&t->value, x);
  test_sum_add(&t->square, x * x);
  t->count++;
}

static inline double test_tally_mean(const test_tally *t) { return test_sum_total(&t->value) / t->count; }

static inline double test_tally_error(const test_tally *t) {
  const double mean = test_tally_mean(t);
  return sqrt(fmax(test_sum_total(&t->square) / t->count - mean * mean, 0.0) / (t->count - 1));
}

#endif
