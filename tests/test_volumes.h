/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes from a formula, for the tests of light. */
#ifndef NP_TEST_VOLUMES_H
#define NP_TEST_VOLUMES_H

#include <stdlib.h>

#include "test_support.h"

#include "core/units.h"
#include "volume/volume_private.h"

/* Value of a volume by voxels from its middle. */
typedef float (*test_field)(double x, double y, double z);

/* `edge`³ samples `step_m` apart around `middle_m`. */
static inline neph_result test_volume_create(neph_context *context, test_field field, int edge, np_dvec3 step_m,
                                             np_dvec3 middle_m, neph_volume **out_volume) {
  const int count = edge * edge * edge;
  const double middle = 0.5 * (edge - 1), step[3] = {step_m.x, step_m.y, step_m.z};
  const double place[3] = {middle_m.x, middle_m.y, middle_m.z};
  float *values = malloc((size_t)count * sizeof *values);
  for (int n = 0; n < count; n++)
    values[n] = field(n % edge - middle, n / edge % edge - middle, n / edge / edge - middle);
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) {
    desc.size[a] = (uint32_t)edge;
    desc.index_to_world[a][a] = step[a];
    desc.index_to_world[a][3] = place[a] - middle * step[a];
  }
  desc.values = values;
  desc.precision = NEPH_PRECISION_FLOAT;
  const neph_result result = neph_volume_create_dense(context, &desc, out_volume);
  free(values);
  return result;
}

/* ---- Fields ---- */

/* Samples along an edge of a volume that holds any of these. */
enum { TEST_EDGE = 24 };

static inline float test_full(double x, double y, double z) { return (void)x, (void)y, (void)z, 1.0f; }

/* A ball of 10 voxels that fades out over its last 2. */
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
