/* SPDX-License-Identifier: Apache-2.0 */
/* The model of cost: sums over units of work, and counts of a trial of clouds whose shape is known. */
#include <nephos/scene_build.h>

#include "plan/plan.h"
#include "plan/trial.h"
#include "test_volumes.h"

/* A block of 24 samples along each side, 20 m apart, from -230 to 230 m around a height of 1000 m. */
static const char scene_text[] =
    "camera: {kind: orthographic, orthographic_width: 1840 m, position: [0, -3 km, 1000 m], look_at: [0, 0, 1000 m],\n"
    "  resolution: [64, 64]}\n"
    "sun: {elevation: 40 deg}\n"
    "render: {samples: 2}\n";

static neph_scene *load_block_of(test_fixture *f, double extinction_per_m) {
  neph_scene *scene;
  neph_volume *volume;
  neph_placement_desc desc = NEPH_PLACEMENT_DESC_DEFAULT;
  desc.density_value = extinction_per_m;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(test_volume_create(f->context, test_full, TEST_EDGE, np_dvec3_make(20, 20, 20),
                                      np_dvec3_make(0, 0, 1000), &volume),
                   NEPH_OK);
  assert_int_equal(neph_scene_add_volume(scene, volume, &desc, NULL), NEPH_OK);
  neph_volume_release(volume);
  return scene;
}

static neph_scene *load_block(test_fixture *f) { return load_block_of(f, 0.01); }

static void measure(const neph_scene *scene, np_input_store *store, np_plan *out) {
  assert_int_equal(np_plan_make(scene, NULL, out), NEPH_OK);
  assert_null(out->inputs.trial); /* no picture without a goal waits for a trial */
  assert_int_equal(np_plan_measure_fill(scene, out, store), NEPH_OK);
}

static void clear(test_fixture *f, neph_scene *scene, np_input_store *store, np_plan *plan) {
  np_plan_clear(plan);
  np_input_store_clear(f->context, store);
  neph_scene_destroy(scene);
}

/* Each stage's seconds and bytes are its counts times the constants, and the picture's their sum. */
static void costs_are_sums_over_units(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load_block(f);
  np_input_store store = {.references = NULL};
  np_plan plan;
  np_cost_counts all = {{0}};
  measure(scene, &store, &plan);
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_stage_forecast *stage = &plan.forecast.stages[i];
    assert_near(stage->cost.seconds, np_costs_sum(&stage->counts).seconds, 1e-12); /* sums of the same doubles */
    for (int u = 0; u < NP_UNIT_COUNT; u++) {
      assert_true(stage->counts.of[u] >= 0.0 && isfinite(stage->counts.of[u]));
      all.of[u] += stage->counts.of[u];
    }
  }
  assert_near_relative(np_costs_sum(&all).seconds, plan.forecast.constant_s, 1e-12);
  assert_near_relative(np_costs_sum(&all).bytes + np_costs_sum(&plan.forecast.program).bytes,
                       np_plan_predict_memory(&plan), 1e-6); /* whole bytes of five parts */
  assert_true(all.of[NP_UNIT_CLEAR_SAMPLE] == 64.0 * 64.0 * 2.0);
  clear(f, scene, &store, &plan);
}

/* Edits of a draft reuse its clouds: the time of which probes take a share leaves them out. */
static void drafts_are_probed_without_their_clouds(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load_block(f);
  np_input_store store = {.references = NULL};
  np_plan plan;
  double sum_s = 0.0;
  scene->render.light_residual = 0.03;
  measure(scene, &store, &plan);
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (i != NP_STAGE_VOLUMES) sum_s += np_costs_sum(&plan.forecast.stages[i].counts).seconds;
  assert_true(plan.forecast.stages[NP_STAGE_VOLUMES].cost.seconds > 0.0);
  assert_near_relative(plan.forecast.constant_s, sum_s, 1e-12);
  clear(f, scene, &store, &plan);
}

/* A quarter of the picture's width and height is block: a sixteenth, but for a ray of 32 on each side. Each such ray is
 * 460 m long, of depth 4.6, but for a step of the map of a 64th; in a block of half as much extinction again it is
 * opaque at a depth of 6, behind 400 m. */
static void a_trial_sees_the_cover_of_a_block(void **state) {
  static const double extinctions_per_m[] = {0.01, 0.015}, lengths_m[] = {460.0, 400.0};
  test_fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    neph_scene *scene = load_block_of(f, extinctions_per_m[i]);
    np_input_store store = {.references = NULL};
    np_plan plan;
    measure(scene, &store, &plan);
    const np_view_counts *view = &plan.inputs.view;
    assert_near(view->cover, 1.0 / 16.0, 2.0 * 8.0 / 1024.0);
    assert_near(view->length_m / view->cover, lengths_m[i], 460.0 * 2.0 / 64.0);
    clear(f, scene, &store, &plan);
  }
}

static bool has_cloud(const np_plan *plan, double x, double z) {
  return np_trial_has_cloud(plan->inputs.trial, np_dvec3_make(x - 20, -20, z - 20), np_dvec3_make(x + 20, 20, z + 20));
}

static void a_trial_has_cloud_where_the_block_is(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load_block(f);
  np_input_store store = {.references = NULL};
  np_plan plan;
  measure(scene, &store, &plan);
  assert_true(has_cloud(&plan, 0, 1000) && has_cloud(&plan, 220, 790) && has_cloud(&plan, -220, 1210));
  assert_false(has_cloud(&plan, 280, 1000) || has_cloud(&plan, 0, 720) || has_cloud(&plan, 0, 1280));
  assert_near(plan.inputs.trial->thickness_m, 460.0, 1.0);
  clear(f, scene, &store, &plan);
}

/* A second plan of the same clouds takes the trial of the store; other places make another. */
static void a_trial_is_made_once(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load_block(f);
  np_input_store store = {.references = NULL};
  np_plan plan, again;
  measure(scene, &store, &plan);
  scene->render.light_depth = 0.9;
  measure(scene, &store, &again);
  assert_ptr_equal(plan.inputs.trial, again.inputs.trial);
  np_plan_clear(&again);
  scene->clouds[0].rotation_rad = 0.5;
  measure(scene, &store, &again);
  assert_ptr_not_equal(plan.inputs.trial, again.inputs.trial);
  np_plan_clear(&again);
  clear(f, scene, &store, &plan);
}

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

#define COST_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      COST_TEST(costs_are_sums_over_units),
      COST_TEST(drafts_are_probed_without_their_clouds),
      COST_TEST(a_trial_sees_the_cover_of_a_block),
      COST_TEST(a_trial_has_cloud_where_the_block_is),
      COST_TEST(a_trial_is_made_once),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
