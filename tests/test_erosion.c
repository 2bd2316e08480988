/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <math.h>

#include "core/random.h"
#include "terrain/erosion.h"

enum { SIDE = 65, COUNT = SIDE * SIDE };

static int set_up(void **state) {
  *state = test_context_create(2, NULL);
  return 0;
}

static int tear_down(void **state) {
  neph_context_destroy(*state);
  return 0;
}

static bool is_on_rim(unsigned i) {
  return i % SIDE == 0 || i % SIDE == SIDE - 1 || i / SIDE == 0 || i / SIDE == SIDE - 1;
}

static np_erosion make_ground(neph_context *context, unsigned side, float uplift) {
  np_erosion erosion;
  assert_int_equal(np_erosion_create(context, side, 1.0f / (float)(side - 1), 1e-3f, &erosion), NEPH_OK);
  for (unsigned i = 0; i < side * side; i++) erosion.uplift[i] = uplift;
  return erosion;
}

/* Random bumps: most samples are pits or drain into one. */
static void roughen(np_erosion *erosion) {
  np_random random = np_random_start(9, 0, 0, 0, 0);
  for (unsigned i = 0; i < COUNT; i++) erosion->height[i] = is_on_rim(i) ? 0 : np_random_float(&random);
}

/* One sample amid a rim at 0. A step takes h to (h + U·t)/(1 + F), F = √(spacing² + A₀)·t/spacing, and smoothing then
 * leaves 3/4 of it; at rest h = ¾·U·t/(¼ + F). Floats of 24 bits, some operations: 1e-6. */
static void a_lone_peak_comes_to_rest(void **state) {
  np_erosion erosion = make_ground(*state, 3, 2.0f);
  const double time = 0.25, power = sqrt(0.5 * 0.5 + 1e-3) * time / 0.5;
  for (int step = 0; step < 200; step++)
    assert_int_equal(np_erosion_step(*state, NULL, &erosion, (float)time), NEPH_OK);
  assert_near_relative((double)erosion.height[4], 0.75 * 2.0 * time / (0.25 + power), 1e-6);
  np_erosion_destroy(*state, &erosion);
}

/* The equation is linear in height: twice the uplift makes twice the mountains, to the bit. */
static void heights_are_proportional_to_uplift(void **state) {
  np_erosion one = make_ground(*state, SIDE, 1.0f), two = make_ground(*state, SIDE, 2.0f);
  np_erosion_scatter(&one, 5);
  np_erosion_scatter(&two, 5);
  for (int step = 0; step < 20; step++) {
    assert_int_equal(np_erosion_step(*state, NULL, &one, 0.5f), NEPH_OK);
    assert_int_equal(np_erosion_step(*state, NULL, &two, 0.5f), NEPH_OK);
  }
  for (unsigned i = 0; i < COUNT; i++) assert_true(two.height[i] == 2.0f * one.height[i]);
  np_erosion_destroy(*state, &one);
  np_erosion_destroy(*state, &two);
}

/* Fills by relaxation: H = max(h, least H of the neighbours + a hundredth of the spacing), until nothing changes. */
static void fill_slowly(const float *ground, float spacing, float *out) {
  for (unsigned i = 0; i < COUNT; i++) out[i] = is_on_rim(i) ? ground[i] : INFINITY;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (unsigned i = 0; i < COUNT; i++) {
      if (is_on_rim(i)) continue;
      float lowest = INFINITY;
      for (unsigned k = 0; k < 9; k++)
        if (k != 4) lowest = fminf(lowest, out[i + (k / 3 - 1) * SIDE + k % 3 - 1]);
      const float filled = fmaxf(ground[i], lowest + 0.01f * spacing);
      is_changed = is_changed || filled < out[i];
      out[i] = fminf(out[i], filled);
    }
  }
}

static void basins_are_filled_no_higher_than_they_must(void **state) {
  np_erosion erosion = make_ground(*state, SIDE, 0.0f);
  static float expected[COUNT];
  roughen(&erosion);
  fill_slowly(erosion.height, erosion.spacing, expected);
  assert_int_equal(np_erosion_fill_basins(*state, NULL, &erosion), NEPH_OK);
  for (unsigned i = 0; i < COUNT; i++) assert_true(erosion.height[i] == expected[i]);
  np_erosion_destroy(*state, &erosion);
}

/* The lowest neighbours lead from everywhere down to the rim; filling never lowers the ground. */
static void filled_basins_drain(void **state) {
  np_erosion erosion = make_ground(*state, SIDE, 0.0f), before = make_ground(*state, SIDE, 0.0f);
  roughen(&erosion);
  roughen(&before);
  assert_int_equal(np_erosion_fill_basins(*state, NULL, &erosion), NEPH_OK);
  for (unsigned i = 0; i < COUNT; i++) {
    assert_true(erosion.height[i] >= before.height[i]);
    if (is_on_rim(i)) continue;
    float lowest = INFINITY;
    for (unsigned k = 0; k < 9; k++) lowest = fminf(lowest, erosion.height[i + (k / 3 - 1) * SIDE + k % 3 - 1]);
    assert_true(lowest < erosion.height[i]);
  }
  np_erosion_destroy(*state, &erosion);
  np_erosion_destroy(*state, &before);
}

static void the_rim_stays_at_zero(void **state) {
  np_erosion erosion = make_ground(*state, SIDE, 1.0f);
  roughen(&erosion);
  for (int step = 0; step < 50; step++) assert_int_equal(np_erosion_step(*state, NULL, &erosion, 1.0f), NEPH_OK);
  for (unsigned i = 0; i < COUNT; i++) assert_true(is_on_rim(i) ? erosion.height[i] == 0 : erosion.height[i] > 0);
  np_erosion_destroy(*state, &erosion);
}

/* A plane is the same plane at any resolution, from lattice points: bilinear sums round to 1e-6. */
static void resampling_keeps_a_plane(void **state) {
  np_erosion erosion = make_ground(*state, SIDE, 0);
  for (unsigned i = 0; i < COUNT; i++) erosion.height[i] = 0.25f * (float)(i % SIDE) - 0.5f * (float)(i / SIDE);
  static float fine[129 * 129];
  assert_int_equal(np_erosion_resample(*state, NULL, &erosion, 129, fine), NEPH_OK);
  for (unsigned i = 0; i < 129 * 129; i++) assert_near((double)fine[i], 0.125 * (i % 129) - 0.25 * (i / 129), 1e-5);
  np_erosion_destroy(*state, &erosion);
}

static neph_result create_and_destroy(neph_context *context, void *user) {
  (void)user;
  np_erosion erosion;
  neph_result result = np_erosion_create(context, SIDE, 1.0f, 1.0f, &erosion);
  np_erosion_destroy(context, &erosion);
  return result;
}

static void failed_allocations_leave_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(create_and_destroy, NULL);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
  const struct CMUnitTest tests[] = {
      TEST(a_lone_peak_comes_to_rest),
      TEST(heights_are_proportional_to_uplift),
      TEST(basins_are_filled_no_higher_than_they_must),
      TEST(filled_basins_drain),
      TEST(the_rim_stays_at_zero),
      TEST(resampling_keeps_a_plane),
      TEST(failed_allocations_leave_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
