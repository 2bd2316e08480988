/* SPDX-License-Identifier: Apache-2.0 */
#include "test_clouds.h"

/* With its own voxels, and with voxels twice as large: the census looks at the same heights as the bake. */
static void every_preset_covers_what_it_says(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (size_t i = 0; i < TEST_PRESET_COUNT; i++) {
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    assert_int_equal(neph_cloud_get_preset(context, test_presets[i], &desc), NEPH_OK);
    desc.precipitation = 0; /* rain is not cloud */
    for (int coarser = 1; coarser <= 2; coarser++) {
      assert_near(test_compute_covered(context, &desc), desc.coverage, 0.05);
      desc.voxel_m *= 2;
    }
  }
  neph_context_destroy(context);
}

static void every_preset_gives_the_same_bits(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (size_t i = 0; i < TEST_PRESET_COUNT; i++) {
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    assert_int_equal(neph_cloud_get_preset(context, test_presets[i], &desc), NEPH_OK);
    desc.extent_m[0] = desc.extent_m[1] = 0.4 * desc.extent_m[0];
    desc.voxel_m = desc.extent_m[0] / 50;
    desc.time_s = 100;
    test_check_bits(2, &desc, 1);
  }
  neph_context_destroy(context);
}

static void an_unknown_preset_lists_those_there_are(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, "cumulus", &desc), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "\"cumulus\"", "cumulus_humilis", "cumulus_mediocris", "cumulus_congestus", "stratocumulus");
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_preset_covers_what_it_says),
      cmocka_unit_test(every_preset_gives_the_same_bits),
      cmocka_unit_test(an_unknown_preset_lists_those_there_are),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
