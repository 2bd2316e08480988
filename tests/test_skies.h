/* SPDX-License-Identifier: Apache-2.0 */
/* Fixture of the tests of skies: Earths, directions and suns in degrees, questions to the tracer. */
#ifndef NP_TEST_SKIES_H
#define NP_TEST_SKIES_H

#include <string.h>

#include "test_support.h"

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/sky_reference.h"
#include "core/units.h"

/* Unit vector under a zenith angle and an azimuth from x, towards which the sun stands. */
static inline np_dvec3 test_direction(double zenith_deg, double azimuth_deg) {
  const double zenith = zenith_deg * NP_DEGREE, azimuth = azimuth_deg * NP_DEGREE;
  return np_dvec3_make(sin(zenith) * cos(azimuth), sin(zenith) * sin(azimuth), cos(zenith));
}

/* A ray to wherever the air ends, from an altitude over the origin. */
static inline np_reference_query test_query(double altitude_m, double zenith_deg, double azimuth_deg) {
  return (np_reference_query){np_dvec3_make(0, 0, altitude_m), test_direction(zenith_deg, azimuth_deg), INFINITY,
                              false};
}

/* An Earth to change, with room for layers of one's own after its molecules, aerosol and ozone. */
enum { TEST_MOLECULES, TEST_AEROSOL, TEST_OZONE, TEST_LAYERS_MAX = 6 };

typedef struct test_air {
  neph_atmosphere_desc desc; /* uses `layers` below */
  neph_atmosphere_layer layers[TEST_LAYERS_MAX];
} test_air;

static inline void test_air_start(test_air *air) {
  air->desc = (neph_atmosphere_desc)NEPH_ATMOSPHERE_DESC_DEFAULT;
  memcpy(air->layers, neph_earth_layers, sizeof neph_earth_layers);
  air->desc.layers = air->layers;
}

/* Haze of one lobe, without an aureole, as published skies have it. */
static inline void test_air_set_one_lobe(test_air *air) {
  air->layers[TEST_AEROSOL].phase = NEPH_PHASE_CORNETTE_SHANKS;
}

/* Multiplies the coefficients of one layer. */
static inline void test_air_scale(test_air *air, int layer, double factor) {
  for (int b = 0; b < 3; b++) {
    air->layers[layer].scattering_per_m[b] *= factor;
    air->layers[layer].absorption_per_m[b] *= factor;
  }
}

static inline void test_air_set_albedo(test_air *air, double albedo) {
  for (int b = 0; b < 3; b++) air->desc.ground_albedo[b] = albedo;
}

static inline neph_atmosphere *test_atmosphere_create(neph_context *context, const neph_atmosphere_desc *desc) {
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, desc, &atmosphere), NEPH_OK);
  return atmosphere;
}

/* A sky under a sun whose azimuth is along x, seen from above the origin. */
static inline neph_sky_desc test_sky_desc(double altitude_m, double sun_deg) {
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  const np_dvec3 sun = test_direction(sun_deg, 0.0);
  desc.sun_direction[0] = sun.x;
  desc.sun_direction[1] = sun.y;
  desc.sun_direction[2] = sun.z;
  desc.observer_m[2] = altitude_m;
  return desc;
}

static inline neph_sky *test_sky_create(neph_atmosphere *earth, double altitude_m, double sun_deg) {
  const neph_sky_desc desc = test_sky_desc(altitude_m, sun_deg);
  neph_sky *sky = NULL;
  assert_int_equal(neph_sky_create(earth, &desc, &sky), NEPH_OK);
  return sky;
}

/* A group of tests whose state is the Earth's air. */
static inline int test_earth_start(void **state) {
  neph_context *context = test_context_create(2, NULL);
  *state = test_atmosphere_create(context, NULL);
  neph_context_destroy(context);
  return 0;
}

static inline int test_earth_end(void **state) {
  neph_atmosphere_release(*state);
  return 0;
}

#endif
