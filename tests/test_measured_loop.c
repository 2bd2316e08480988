/* SPDX-License-Identifier: Apache-2.0 */
/* The closed loop of measured maps: reflectances of a deck of stratocumulus, rendered from above under a low sun, give
 * its optical depths and its coverage back. bench_measured_loop prints more cases, and cumulus. */
#include "measured_loop.h"

static int set_up(void **state) { return test_set_up(state, 2, "map.tif"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

/* Light that flows sideways evens a reflectance out over some hundred metres, and the plane-parallel table leaves it
 * out: 15 % in blocks of 2 km. The second picture is darker by a tenth: gaps of its texture do not lie in the pixels
 * that were dark for theirs, so that columns beside them are deeper. */
static void a_deck_comes_back_from_its_picture(void **state) {
  test_fixture *f = *state;
  const loop_case deck = {"deck", LOOP_DECK, 3, 64, 8000, 62.5, 500, 30};
  loop_result r;
  assert_int_equal(loop_run(f->context, &deck, f->path, &r), NEPH_OK);
  assert_true(r.low > 1.5 && r.high > 15 && r.high < 60);
  assert_near(r.block_rms, 0, 0.15);
  assert_near(r.covered[1], r.covered[0], 0.03);
  assert_near(r.reflectance[1], r.reflectance[0], 0.1);
  loop_clear(&r);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(a_deck_comes_back_from_its_picture)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
