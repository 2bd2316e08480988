/* SPDX-License-Identifier: Apache-2.0 */
/* Ground of known shape for the tests of terrain. */
#ifndef NP_TEST_TERRAINS_H
#define NP_TEST_TERRAINS_H

#include <stdlib.h>

#include "test_support.h"

#include "core/units.h"
#include "terrain/terrain_private.h"

static const double radius_m = 6360e3;

/* Float vertices about the field's middle are rounded by up to 2⁻⁹ m on each axis at 32 to 64 km; a facet is a chord
 * that dips diagonal²/8R below the sphere, 0.3 mm at 131 m. */
static const double surface_tolerance_m = 0.006;

static inline int set_up(void **state) { return test_set_up(state, 2, NULL); }

/* A field that ends at the sphere, so that its box and its corners are known. */
static inline neph_terrain_desc describe_fading(void) {
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.edge = NEPH_TERRAIN_EDGE_FADE;
  return desc;
}

/* A tile of one degree whose south-western corner is N44 W072, with synthetic elevations. */
static inline neph_terrain *make_tile(test_fixture *f, int (*elevation)(unsigned column, unsigned row)) {
  char *path = test_hgt_write(f->folder, "N44W072.hgt", 1201, elevation);
  const neph_terrain_desc desc = describe_fading();
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  free(path);
  return terrain;
}

static inline neph_terrain *make_ridges(neph_context *context, unsigned sample_count) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = sample_count;
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_create_ridges(context, &ridges, NULL, &terrain), NEPH_OK);
  return terrain;
}

static inline np_dvec3 place_sample(const np_heightfield *field, const np_globe *globe, unsigned column, unsigned row) {
  return np_globe_to_world(globe, field->south_rad + row * field->step_north_rad,
                           field->west_rad + column * field->step_east_rad,
                           (double)field->elevation_m[(size_t)row * field->width + column]);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

#endif
