/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in a vacuum and the light in them: what the tests of light start from. Air, ground and lights are added by the
 * test. */
#ifndef NP_TEST_WORLD_H
#define NP_TEST_WORLD_H

#include "test_rays.h"
#include "test_volumes.h"

#include "caches/lighting.h"

/* A white cloud. */
typedef struct test_cloud {
  test_field field;
  float extinction_per_m; /* where the field is 1 */
  np_phase phase;
  int edge; /* number of samples along each axis */
  np_dvec3 step_m, middle_m;
} test_cloud;

/* TEST_EDGE³ samples 1 m apart around the origin. */
static inline test_cloud test_cloud_make(test_field field, float extinction_per_m, np_phase phase) {
  return (test_cloud){field, extinction_per_m, phase, TEST_EDGE, {1.0, 1.0, 1.0}, {0.0, 0.0, 0.0}};
}

/* The same on x and y ≥ 0, from `bottom_m` upwards; the balls are some 10 thick through the middle. */
static inline test_cloud test_cloud_make_on_axes(test_field field, double bottom_m) {
  test_cloud cloud = test_cloud_make(field, 0.5f, np_phase_henyey_greenstein(0.85f));
  const double half = 0.5 * (TEST_EDGE - 1);
  cloud.middle_m = np_dvec3_make(half, half, bottom_m + half);
  return cloud;
}

enum { TEST_CLOUDS_MAX = 3 };

/* Not to be copied: it holds pointers to its own parts. */
typedef struct test_world {
  neph_context *context;
  neph_volume *volumes[TEST_CLOUDS_MAX];
  np_instance placed[TEST_CLOUDS_MAX];
  np_world world; /* dark; the sun stands at the zenith */
  np_lighting lighting;
  np_integrator_settings settings;
  np_scattering_desc desc;         /* its bounds are those of the first cloud's samples */
  np_scattering_field *scattering; /* NULL: not solved for */
} test_world;

/* Empty. */
static inline void test_world_init(test_world *w, neph_context *context) {
  *w = (test_world){.context = context,
                    .world = {.clouds.at = w->placed, .to_sun = {0, 0, 1}},
                    .lighting.sun_optical_depths.clouds = &w->world.clouds,
                    .settings = test_integrator_settings(),
                    .desc = NP_SCATTERING_DESC_DEFAULT};
}

static inline neph_result test_world_add(test_world *w, test_cloud cloud) {
  const unsigned i = w->world.clouds.count;
  const neph_result result =
      test_volume_create(w->context, cloud.field, cloud.edge, cloud.step_m, cloud.middle_m, &w->volumes[i]);
  if (result) return result;
  w->placed[i] = (np_instance){.bricks = &w->volumes[i]->bricks,
                               .world_to_index = w->volumes[i]->world_to_index,
                               .extinction_per_value = cloud.extinction_per_m,
                               .albedo = np_spectrum_grey(1.0f),
                               .phase = cloud.phase};
  w->world.clouds.count++;
  if (i > 0) return NEPH_OK;
  const np_dvec3 half = np_dvec3_scale(cloud.step_m, 0.5 * (cloud.edge - 1));
  w->desc.cells.bounds_min = np_dvec3_subtract(cloud.middle_m, half);
  w->desc.cells.bounds_max = np_dvec3_add(cloud.middle_m, half);
  return NEPH_OK;
}

/* One cloud, in a context of its own. */
static inline void test_world_create(test_world *w, unsigned threads, test_cloud cloud) {
  test_world_init(w, test_context_create(threads, NULL));
  assert_int_equal(test_world_add(w, cloud), NEPH_OK);
}

/* Multiple scattering under the present light. */
static inline neph_result test_world_solve(test_world *w) {
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&w->lighting.sun_optical_depths);
  const neph_result result = np_scattering_field_build(w->context, &w->world, &depths, &w->desc, NULL, &w->scattering);
  w->lighting.scattering = w->scattering;
  return result;
}

/* Leaves the context alone. */
static inline void test_world_clear(test_world *w) {
  np_scattering_field_destroy(w->scattering);
  for (int i = 0; i < TEST_CLOUDS_MAX; i++) neph_volume_release(w->volumes[i]);
}

static inline void test_world_destroy(test_world *w) {
  test_world_clear(w);
  neph_context_destroy(w->context);
}

/* ---- Integrators ---- */

static inline void test_world_march(const test_world *w, const np_camera_ray *ray, np_random *random,
                                    np_integrator_sample *out) {
  test_integrators(w->context)->march(&w->world, &w->lighting, &w->settings, ray, random, out);
}

static inline void test_world_path(const test_world *w, const np_camera_ray *ray, np_random *random,
                                   np_integrator_sample *out) {
  test_integrators(w->context)->path(&w->world, &w->lighting, &w->settings, ray, random, out);
}

#endif
