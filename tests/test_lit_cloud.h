/* SPDX-License-Identifier: Apache-2.0 */
/* One white cloud 20 m across, and the light solved in it. */
#ifndef NP_TEST_LIT_CLOUD_H
#define NP_TEST_LIT_CLOUD_H

#include "transport/scattering_field.h"
#include "test_volumes.h"

/* Its box stands on x and y ≥ 0; some 10 deep through the middle. */
typedef struct test_lit_cloud {
  neph_context *context; /* not owned */
  neph_volume *volume;
  np_instance placed;
  np_world world; /* of no light yet */
  np_scattering_desc desc;
  np_scattering_field scatter;
} test_lit_cloud;

static inline neph_result test_lit_cloud_create(neph_context *context, test_field field, double base_m,
                                                test_lit_cloud *out_cloud) {
  test_lit_cloud *c = out_cloud;
  *c = (test_lit_cloud){.context = context, .desc = NP_SCATTERING_DESC_DEFAULT};
  const neph_result result = test_volume_create(context, TEST_EDGE, np_dvec3_make(0, 0, base_m), field, &c->volume);
  if (result) return result;
  c->placed = test_volume_place(c->volume, 0.5f, np_phase_henyey_greenstein(0.85f));
  c->world = (np_world){.clouds.count = 1, .clouds.at = &c->placed};
  c->desc.cells.bounds_min = np_dvec3_make(0, 0, base_m);
  c->desc.cells.bounds_max = np_dvec3_make(TEST_EDGE - 1, TEST_EDGE - 1, base_m + TEST_EDGE - 1);
  return NEPH_OK;
}

static inline neph_result test_lit_cloud_solve(test_lit_cloud *cloud) {
  test_lit_cloud *c = cloud;
  const neph_result result = np_scattering_field_build(c->context, &c->world, &c->desc, NULL, &c->scatter);
  if (!result) c->world.scattering = &c->scatter;
  return result;
}

static inline void test_lit_cloud_clear(test_lit_cloud *cloud) {
  np_scattering_field_clear(&cloud->scatter);
  neph_volume_release(cloud->volume);
}

#endif
