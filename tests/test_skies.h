/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of skies share: Earths, directions and suns in degrees, questions to the tracer. */
#ifndef NP_TEST_SKIES_H
#define NP_TEST_SKIES_H

#include "test_support.h"

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/sky_truth.h"
#include "core/units.h"

/* Unit vector under a zenith angle and an azimuth from x, towards which the sun stands. */
static inline np_dvec3 test_direction(double zenith_deg, double azimuth_deg) {
  const double zenith = zenith_deg * NP_DEGREE, azimuth = azimuth_deg * NP_DEGREE;
  return np_dvec3_make(sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth), cos(zenith));
}

/* A ray to wherever the air ends, from an altitude over the origin. */
static inline np_truth_query test_query(double altitude_m, double zenith_deg, double azimuth_deg) {
  return (np_truth_query){np_dvec3_make(0, 0, altitude_m), test_direction(zenith_deg, azimuth_deg), INFINITY, false};
}

static inline neph_atmosphere *test_atmosphere_create(neph_context *context, const neph_atmosphere_desc *desc) {
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, desc, &atmosphere), NEPH_OK);
  return atmosphere;
}

#endif
