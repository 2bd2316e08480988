/* SPDX-License-Identifier: Apache-2.0 */
/* Every preset, and every model: rows of the tables, whatever their number. */
#include "scene/scene_keys.h"
#include "test_clouds.h"

/* Bakes with the preset's voxels, and with voxels twice as large: the census evaluates the same heights as the bake. */
static void every_preset_covers_what_it_says(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(context, i, name); i++) {
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    assert_int_equal(neph_cloud_get_preset(context, name, &desc), NEPH_OK);
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
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(context, i, name); i++) {
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    assert_int_equal(neph_cloud_get_preset(context, name, &desc), NEPH_OK);
    desc.extent_m[0] = desc.extent_m[1] = 0.4 * desc.extent_m[0];
    desc.voxel_m = desc.extent_m[0] / 50;
    desc.time_s = 100;
    test_check_bits(2, &desc, 1);
  }
  neph_context_destroy(context);
}

/* Models that no preset is of. */
static const neph_cloud_model models_alone[] = {NEPH_CLOUD_MODEL_CELLS, NEPH_CLOUD_MODEL_HERO};

enum { MODELS_ALONE = sizeof models_alone / sizeof *models_alone };

static bool has_example(neph_context *context, neph_cloud_model model) {
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; i < MODELS_ALONE; i++)
    if (models_alone[i] == model) return true;
  for (size_t i = 0; test_get_preset(context, i, name); i++) {
    neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
    assert_int_equal(neph_cloud_get_preset(context, name, &desc), NEPH_OK);
    if (desc.model == model) return true;
  }
  return false;
}

static void every_model_has_an_example(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  for (const np_choice *word = np_key_search_path("clouds[].bake.model")->choices; word->name; word++)
    if (!has_example(context, (neph_cloud_model)word->value))
      fail_msg("the model %s has no example: add a preset of it to src/cloud/presets.c, or the model to "
               "`models_alone` in tests/test_cloud_presets.c",
               word->name);
  neph_context_destroy(context);
}

static void every_model_alone_gives_the_same_bits(void **state) {
  (void)state;
  for (size_t i = 0; i < MODELS_ALONE; i++) {
    neph_cloud_desc desc = test_small_field(7);
    desc.model = models_alone[i];
    desc.voxel_m = 100;
    test_check_bits(2, &desc, 1);
  }
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
      cmocka_unit_test(every_model_has_an_example),
      cmocka_unit_test(every_model_alone_gives_the_same_bits),
      cmocka_unit_test(an_unknown_preset_lists_those_there_are),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
