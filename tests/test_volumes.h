/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds for the tests of light: volumes made of a formula, and placed in a scene. */
#ifndef NP_TEST_VOLUMES_H
#define NP_TEST_VOLUMES_H

#include <stdlib.h>

#include "test_support.h"

#include "core/units.h"
#include "world/world.h"
#include "volume/volume_private.h"

/* Values of a volume, by metres from its middle. */
typedef float (*test_field)(double x, double y, double z);

/* `edge`³ samples 1 m apart, the first of them at `first_m`. */
static inline neph_result test_volume_create(neph_context *context, int edge, np_dvec3 first_m, test_field field,
                                             neph_volume **out_volume) {
  const int count = edge * edge * edge;
  const double middle = 0.5 * (edge - 1);
  float *values = malloc((size_t)count * sizeof *values);
  for (int n = 0; n < count; n++)
    values[n] = field(n % edge - middle, n / edge % edge - middle, n / edge / edge - middle);
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) desc.size[a] = (uint32_t)edge;
  desc.index_to_world[0][3] = first_m.x;
  desc.index_to_world[1][3] = first_m.y;
  desc.index_to_world[2][3] = first_m.z;
  desc.values = values;
  desc.precision = NEPH_PRECISION_FLOAT;
  const neph_result result = neph_volume_create_dense(context, &desc, out_volume);
  free(values);
  return result;
}

/* The same, its middle at the origin. */
static inline neph_volume *test_volume_create_centred(neph_context *context, int edge, test_field field) {
  const double corner = -0.5 * (edge - 1);
  neph_volume *volume = NULL;
  assert_int_equal(test_volume_create(context, edge, np_dvec3_make(corner, corner, corner), field, &volume), NEPH_OK);
  return volume;
}

/* White where it is not told otherwise. */
static inline np_instance test_volume_place(const neph_volume *volume, float extinction_per_value, np_phase phase) {
  return (np_instance){.bricks = &volume->bricks,
                          .world_to_index = volume->world_to_index,
                          .extinction_per_value = extinction_per_value,
                          .albedo = np_spectrum_grey(1.0f),
                          .phase = phase};
}

/* ---- Fields ---- */

/* Samples along an edge of a volume that holds any of these. */
enum { TEST_EDGE = 24 };

static inline float test_full(double x, double y, double z) { return (void)x, (void)y, (void)z, 1.0f; }

/* A ball of 10 m that fades out over its last 2 m. */
static inline float test_soft_ball(double x, double y, double z) {
  return (float)(fmax(0.0, fmin(100.0 - x * x - y * y - z * z, 40.0)) / 40.0);
}

static inline float test_lumpy_ball(double x, double y, double z) {
  return test_soft_ball(x, y, z) * (float)(1.0 + 0.5 * sin(x) * cos(y + z));
}

/* Lumps that are 0 on the faces of the box. */
static inline float test_lumpy_box(double x, double y, double z) {
  const double edge = TEST_EDGE - 1, window = cos(NP_PI * x / edge) * cos(NP_PI * y / edge) * cos(NP_PI * z / edge);
  const double u = x / edge + 0.5, v = y / edge + 0.5, w = z / edge + 0.5;
  const double lumps = 0.5 + 0.5 * sin(17.0 * u + 3.0 * v) * sin(11.0 * v - 5.0 * w) * cos(13.0 * w + 2.0 * u);
  return (float)(window * lumps);
}

#endif
