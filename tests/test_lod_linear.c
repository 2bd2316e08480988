/* SPDX-License-Identifier: Apache-2.0 */
/* Handmade levels of detail: a field of known values on all of them without a step between, and invalid sets of levels.
 */
#include "test_grids.h"
#include "test_support.h"

#include "core/random.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

enum { LEVELS = 3, CELL = NP_LEAF_EDGE << (LEVELS - 1), CELLS = 3 };

/* A field that interpolation gives back without an error. */
static double eval_linear(const double at[3]) { return 1 + 0.01 * at[0] + 0.02 * at[1] + 0.005 * at[2]; }

/* All pairs of levels meet along each axis. */
static unsigned choose_level(const int32_t cell[3]) { return (unsigned)(cell[0] + 2 * cell[1] + cell[2]) % LEVELS; }

static void fill_leaf(unsigned level, np_leaf *leaf) {
  memset(leaf->active, 0xff, sizeof leaf->active);
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const double at[3] = {ldexp(leaf->origin[0] + n / 64, (int)level), ldexp(leaf->origin[1] + n / 8 % 8, (int)level),
                          ldexp(leaf->origin[2] + n % 8, (int)level)};
    leaf->values[n] = (float)eval_linear(at);
  }
}

static void make_linear(neph_context *context, np_sparse_grid levels[LEVELS]) {
  for (unsigned k = 0; k < LEVELS; k++) {
    assert_int_equal(np_sparse_grid_init(context, "density", &levels[k]), NEPH_OK);
    levels[k].index_to_world = np_affine_identity();
    for (int a = 0; a < 3; a++) levels[k].index_to_world.m[a][a] = ldexp(1, (int)k);
    const int leaves = CELLS * CELL >> (3 + k), along = CELL >> (3 + k);
    for (int n = 0; n < leaves * leaves * leaves; n++) {
      const int32_t leaf[3] = {n / leaves / leaves, n / leaves % leaves, n % leaves};
      const int32_t cell[3] = {leaf[0] / along, leaf[1] / along, leaf[2] / along};
      if (choose_level(cell) != k) continue;
      const int32_t origin[3] = {8 * leaf[0], 8 * leaf[1], 8 * leaf[2]};
      fill_leaf(k, np_sparse_grid_add_leaf(&levels[k], origin));
    }
  }
}

static void clear(np_sparse_grid levels[LEVELS]) {
  for (unsigned k = 0; k < LEVELS; k++) np_sparse_grid_clear(&levels[k]);
}

/* A linear field in levels keeps its values from `low` on along each axis to `rim` voxels before the last. */
static void check_linear(uint64_t seed, bool is_halved, unsigned part_count, double low, double rim) {
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid levels[LEVELS];
  neph_volume *volume;
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  make_linear(context, levels);
  assert_int_equal(
      np_volume_create_from_levels(context, levels, LEVELS, is_halved, NEPH_PRECISION_FLOAT, NULL, &volume), NEPH_OK);
  assert_int_equal(np_volume_count_parts(volume), part_count);
  for (int n = 0; n < 20000; n++) {
    double at[3];
    float value;
    for (int a = 0; a < 3; a++) at[a] = low + np_random_double(&random) * (CELLS * CELL - low - rim);
    neph_volume_sample(volume, 1, at, &value);
    assert_near((double)value, eval_linear(at), 1e-5); /* floats round it */
  }
  neph_volume_release(volume);
  clear(levels);
  neph_context_destroy(context);
}

/* The last voxels of the field fade to nothing. */
static void levels_meet_without_a_step(void **state) {
  (void)state;
  check_linear(3, false, LEVELS, 0.0, 1 << (LEVELS - 1));
}

/* Within a limit on memory the finest level goes into the next, by weights that keep a linear field: but for its first
 * samples, at 0, which have nothing before them, for those next to the last voxels, which fade, and for voxels of four
 * at either, which reach as far. */
static void the_finest_level_goes_into_the_next(void **state) {
  (void)state;
  check_linear(4, true, LEVELS - 1, 4.0, 8.0);
}

static void what_is_no_set_of_levels_is_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  static const char *const messages[] = {"both have voxels in the cell from voxel (0, 0, 0)", "holds 1 constant tiles",
                                         "voxels 2 times as long"};
  for (int n = 0; n < 3; n++) {
    const int32_t origin[3] = {0, 0, 0};
    np_sparse_grid levels[LEVELS];
    neph_volume *volume;
    make_linear(context, levels);
    if (n == 0) fill_leaf(1, np_sparse_grid_add_leaf(&levels[1], origin));
    if (n == 1) np_sparse_grid_add_tile(&levels[1], origin, 8, 1, true);
    if (n == 2) levels[1].index_to_world.m[0][3] = 0.5;
    test_log_clear(&log);
    assert_int_equal(np_volume_create_from_levels(context, levels, LEVELS, false, NEPH_PRECISION_FLOAT, NULL, &volume),
                     NEPH_ERROR_BAD_FILE);
    if (!strstr(log.text, messages[n])) fail_msg("%d: %s", n, log.text);
    clear(levels);
  }
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(levels_meet_without_a_step),
      cmocka_unit_test(the_finest_level_goes_into_the_next),
      cmocka_unit_test(what_is_no_set_of_levels_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
