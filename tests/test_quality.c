/* SPDX-License-Identifier: Apache-2.0 */
/* Qualities: the table, keys that win over it, and the size of what a draft computes. */
#include "test_box_files.h"

#include <stdlib.h>
#include <string.h>

#include "plan/plan.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/quality.h"
#include "scene/scene_keys.h"
#include "scene/scene_private.h"
#include "volume/volume_private.h"

static int set_up(void **state) { return test_set_up(state, 1, NULL); }

static neph_scene *load(test_fixture *f, const char *text) {
  neph_scene *scene;
  if (neph_scene_load_text(f->context, text, "s.yaml", &scene)) fail_msg("%s: %s", text, f->log.text);
  return scene;
}

/* ---- The table ---- */

static void test_final_is_the_default_of_each_key(void **state) {
  (void)state;
  for (size_t i = 0; i < np_quality_knob_count(); i++) {
    const np_quality_knob *knob = np_quality_knob_at(i);
    assert_string_equal(np_key_search_path(knob->key)->fallback, knob->value[NP_QUALITY_FINAL]);
  }
}

/* Every value is one that a scene may give. */
static void test_values_are_those_that_keys_take(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "version: 1");
  for (size_t i = 0; i < np_quality_knob_count(); i++)
    for (int q = 0; q < NP_QUALITY_COUNT; q++)
      assert_int_equal(neph_scene_set(scene, np_quality_knob_at(i)->key, np_quality_knob_at(i)->value[q]), NEPH_OK);
  neph_scene_destroy(scene);
}

static void test_quality_chooses(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "render: {quality: draft}");
  assert_int_equal(scene->render.sample_count, 2);
  assert_int_equal(scene->render.light_degree, 3);
  assert_near(scene->render.detail_px, 4, 0);
  assert_int_equal(neph_scene_set(scene, "render.quality", "reference"), NEPH_OK);
  assert_int_equal(scene->render.integrator, NEPH_INTEGRATOR_PATH);
  assert_near(scene->render.detail_px, 0, 0);
  assert_int_equal(neph_scene_set(scene, "render.quality", "final"), NEPH_OK);
  assert_int_equal(scene->render.sample_count, 4);
  neph_scene_destroy(scene);
}

/* Before the quality, after it, or set later. */
static void test_given_keys_win(void **state) {
  test_fixture *f = *state;
  static const char *const texts[] = {"render: {quality: draft, samples: 9}", "render: {samples: 9, quality: draft}"};
  for (int i = 0; i < 2; i++) {
    neph_scene *scene = load(f, texts[i]);
    assert_int_equal(scene->render.sample_count, 9);
    assert_int_equal(neph_scene_set(scene, "render.light_degree", "7"), NEPH_OK);
    assert_int_equal(neph_scene_set(scene, "render.quality", "preview"), NEPH_OK);
    assert_int_equal(scene->render.sample_count, 9);
    assert_int_equal(scene->render.light_degree, 7);
    assert_near(scene->render.tolerance, 0.04, 0);
    neph_scene_destroy(scene);
  }
}

static void test_unknown_quality_is_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, "render: {quality: fast}", "s.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "render.quality is fast", "draft, preview, final or reference");
}

/* ---- Detail ---- */

#define FIELD                                                                                                          \
  "camera: {position: [0 m, -20 km, 1 km], look_at: [0 m, 0 m, 1 km], fov: 53.13010235415598 deg, "                    \
  "resolution: [100, 50]}\n"                                                                                           \
  "terrain: {ridges: {samples: 1025}, width: 40 km}\n"                                                                 \
  "clouds: [{bake: {extent: 8 km, base: 1 km, thickness: 4 km, voxel: 10 m}}]\n"

static np_request request_of(const neph_scene *scene) {
  np_request request = {.context = scene->context, .desc = NEPH_RENDER_DESC_DEFAULT};
  request.desc.width = scene->camera.resolution[0];
  request.desc.height = scene->camera.resolution[1];
  return request;
}

/* Pixels of 1/100 rad: at the field's near side, 16 km away, 160 m wide. Voxels are the largest 10 m·2^(n/2) within. */
static void test_voxels_follow_pixels(void **state) {
  test_fixture *f = *state;
  static const double detail[] = {0, 0.05, 0.1, 0.5, 1}, voxel_m[] = {10, 10, 10 * M_SQRT2, 80, 160};
  neph_scene *scene = load(f, FIELD);
  const np_request request = request_of(scene);
  for (int i = 0; i < 5; i++) {
    scene->render.detail_px = detail[i];
    assert_near(np_plan_get_bake(&request, scene, &scene->clouds[0]).voxel_m, voxel_m[i], 1e-9);
    assert_int_equal(np_plan_is_coarsened(&request, scene, &scene->clouds[0]), voxel_m[i] > 10);
  }
  scene->render.detail_px = 100;
  assert_near(np_plan_get_bake(&request, scene, &scene->clouds[0]).voxel_m, 160, 1e-9); /* 24 to 4 km at the least */
  neph_scene_destroy(scene);
}

/* Heights 39 m apart, seen from an eighth of the width at least: from 5 km a pixel is 50 m wide. Snow halves that. */
static void test_heights_follow_pixels(void **state) {
  test_fixture *f = *state;
  static const double detail[] = {0, 1, 2, 4, 1000};
  static const unsigned samples[] = {1025, 1025, 513, 257, 65}, under_snow[] = {1025, 1025, 1025, 513, 65};
  neph_scene *scene = load(f, FIELD);
  const np_request request = request_of(scene);
  for (int i = 0; i < 5; i++) {
    scene->render.detail_px = detail[i];
    scene->terrain.desc.has_snow = false;
    assert_int_equal(np_plan_get_ridges(&request, scene).sample_count, samples[i]);
    scene->terrain.desc.has_snow = true;
    assert_int_equal(np_plan_get_ridges(&request, scene).sample_count, under_snow[i]);
  }
  neph_scene_destroy(scene);
}

/* A box of 320 m from a file. Pixels of 1/100 rad, cells of eight: at 1 km they are 80 m wide, four along a side.
 * Optical depth, for which the grid would have to be read, changes nothing. */
static void test_cells_in_files_follow_pixels(void **state) {
  test_fixture *f = *state;
  static const test_box box = {{8, 8, 8}, {41, 41, 41}, 1.0f};
  static const double distance_m[] = {1000, 500, 2000}, cells[] = {64, 512, 8};
  test_boxes_write(f->context, f->path, "density", &box, 1);
  for (int i = 0; i < 3; i++) {
    char text[512];
    (void)snprintf(text, sizeof text,
                   "camera: {position: [0 m, %g m, 160 m], look_at: [0 m, 0 m, 160 m], fov: 53.13010235415598 deg, "
                   "resolution: [100, 50]}\n"
                   "clouds: [{vdb: %s, voxel: 10 m, position: [0, 0, 0], optical_depth: 9}]\n",
                   -160 - distance_m[i], f->path);
    neph_scene *scene = load(f, text);
    np_plan plan;
    np_input_store store = {.references = NULL};
    scene->render.light_detail_px = 8;
    assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
    assert_int_equal(np_plan_measure_fill(scene, &plan, &store), NEPH_OK);
    assert_near_relative(plan.inputs.file_cell_count, cells[i], 1e-9);
    np_input_store_clear(f->context, &store);
    np_plan_clear(&plan);
    neph_scene_destroy(scene);
  }
}

/* A filled block of 4096³ in 627 bytes: its cells go by the voxels and the box in its header, not by its bytes, which
 * would be 28 cells. test_vdb_hostile's has 36³ in cloud: whole cells, where the share is of the box. */
static void test_cells_in_a_tile_follow_its_box(void **state) {
  test_fixture *f = *state;
  test_tile_write(f->context, f->path);
  char text[256];
  (void)snprintf(text, sizeof text, "clouds: [{vdb: %s, voxel: 1 m, optical_depth: 40}]", f->path);
  neph_scene *scene = load(f, text);
  np_plan plan;
  np_input_store store = {.references = NULL};
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(np_plan_measure_fill(scene, &plan, &store), NEPH_OK);
  assert_near_relative(plan.inputs.file_voxel_count, 4096.0 * 4096.0 * 4096.0, 1e-9);
  assert_in_range((uint64_t)np_plan_count_cells(&plan, scene).cells, 46656 * 2 / 3, 46656 * 3 / 2);
  np_input_store_clear(f->context, &store);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
}

static int set_up_file(void **state) { return test_set_up(state, 1, "box.vdb"); }

int main(void) {
  static const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_final_is_the_default_of_each_key, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_values_are_those_that_keys_take, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_quality_chooses, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_given_keys_win, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_unknown_quality_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_voxels_follow_pixels, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_heights_follow_pixels, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(test_cells_in_files_follow_pixels, set_up_file, test_tear_down),
      cmocka_unit_test_setup_teardown(test_cells_in_a_tile_follow_its_box, set_up_file, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
