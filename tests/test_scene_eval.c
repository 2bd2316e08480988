/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in a frame, as a value: what a scene with those values would be, beside a scene that stays as it is. */
#include <nephos/nephos.h>

#include "scene/scene_eval.h"
#include "test_scenes.h"

/* Numbers, parts of lists, whole numbers, a time, an element of each list, and keys that exclude others. */
static const char animated[] =
    "camera: {resolution: [16, 9]}\n"
    "frame_rate: 24\n"
    "place: {latitude: 40, longitude: 5}\n"
    "moon: {elevation: 10 deg, azimuth: 20 deg}\n"
    "atmosphere: {layers: [{exponential: {height: 1 km}, bottom: 0 m, top: 20 km, scattering: 3e-5}]}\n"
    "clouds:\n"
    "  - {vdb: a.vdb, mean_free_path: 10 m}\n"
    "  - {bake: {preset: cumulus_mediocris, extent: [800 m, 800 m], top: 3 km, repeat: 2 km,"
    " map: {image: m.##.exr, coverage: R}}}\n"
    "animate:\n"
    "  camera.position: [[1, [0 m, 1 m, 2 m]], [11, [10 m, 21 m, 32 m]]]\n"
    "  camera.look_at.2: [[1, 100 m], [11, 200 m]]\n"
    "  camera.blades: [[1, 3], [11, 8]]\n"
    "  sun.elevation: [[1, 10 deg], [11, 20 deg]]\n"
    "  sun.time: [[1, 2026-06-21T04:00Z], [11, 2026-06-21T05:00Z]]\n"
    "  clouds[0].extinction: [[1, 0.25], [11, 0.75]]\n"
    "  clouds[1].bake.base: [[1, 1 km], [11, 2 km]]\n"
    "  atmosphere.layers[0].scattering: [[1, 1e-5], [11, 1e-5]]\n";

/* The same in frame 6, half way. */
static const char still[] =
    "camera: {resolution: [16, 9], position: [5 m, 11 m, 17 m], look_at: [0 m, 0 m, 150 m], blades: 6}\n"
    "frame_rate: 24\n"
    "place: {latitude: 40, longitude: 5}\n"
    "sun: {time: \"2026-06-21T04:30:00.000Z\"}\n"
    "moon: {elevation: 10 deg, azimuth: 20 deg}\n"
    "atmosphere: {layers: [{exponential: {height: 1 km}, bottom: 0 m, top: 20 km, scattering: 1e-5}]}\n"
    "clouds:\n"
    "  - {vdb: a.vdb, extinction: 0.5}\n"
    "  - {bake: {preset: cumulus_mediocris, extent: [800 m, 800 m], top: 3 km, repeat: 2 km, base: 1.5 km, map: "
    "{image: m.##.exr, coverage: R}}}\n";

static int set_up(void **state) { return set_up_scene(state, 2, animated); }

static char *describe(const neph_scene *scene) {
  char *text;
  assert_int_equal(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  return text;
}

static void assert_described(const neph_scene *scene, const char *expected) {
  char *text = describe(scene);
  assert_string_equal(text, expected);
  neph_text_destroy(scene->context, text);
}

static void a_frame_is_a_scene_with_its_values(void **state) {
  fixture *f = *state;
  neph_scene *plain, at;
  assert_int_equal(neph_scene_load_text(f->context, still, "dir/scene.yaml", &plain), NEPH_OK);
  char *before = describe(f->scene), *expected = describe(plain);
  assert_int_equal(np_scene_eval(f->scene, 6, &at), NEPH_OK);
  assert_described(&at, expected);
  assert_string_equal(at.clouds[1].bake.map_file, "dir/m.06.exr");
  assert_near(at.clouds[1].bake.thickness_m, 1500.0, 0.0);
  assert_near(at.atmosphere.layers[3].scattering_per_m[0], 1e-5, 0.0);
  assert_near(at.sun.time.at.unix_s, plain->sun.time.at.unix_s, 0.0);
  assert_int_equal(at.clouds[1].place_count, plain->clouds[1].place_count);
  assert_memory_equal(at.clouds[1].place, plain->clouds[1].place, at.clouds[1].place_count * sizeof *at.clouds->place);
  assert_described(f->scene, before);
  assert_near(f->scene->camera.position_m[0], 0.0, 0.0);
  neph_text_destroy(f->context, expected);
  neph_text_destroy(f->context, before);
  np_scene_eval_clear(&at);
  neph_scene_destroy(plain);
}

/* The second is that of the scene itself, whatever the first was. */
static void a_frame_can_be_evaluated_in_another(void **state) {
  fixture *f = *state;
  neph_scene first, second, alone;
  assert_int_equal(np_scene_eval(f->scene, 11, &first), NEPH_OK);
  assert_int_equal(np_scene_eval(&first, 3.5, &second), NEPH_OK);
  assert_int_equal(np_scene_eval(f->scene, 3.5, &alone), NEPH_OK);
  char *expected = describe(&alone);
  assert_described(&second, expected);
  assert_int_equal(second.clouds[1].place_count, alone.clouds[1].place_count);
  assert_memory_equal(second.clouds[1].place, alone.clouds[1].place,
                      alone.clouds[1].place_count * sizeof *alone.clouds->place);
  neph_text_destroy(f->context, expected);
  np_scene_eval_clear(&second);
  np_scene_eval_clear(&first);
  np_scene_eval_clear(&alone);
}

static void steps_stay_within_an_exposure(void **state) {
  fixture *f = *state;
  neph_scene at;
  set(f, "animate.camera.position", "{interpolation: step, keys: [[1, [1 m, 0 m, 0 m]], [5, [2 m, 0 m, 0 m]]]}");
  assert_int_equal(np_scene_eval_exposure(f->scene, 5.25, 4.0, &at), NEPH_OK);
  assert_near(at.camera.position_m[0], 1.0, 0.0);
  assert_near(at.camera.look_at_m[2], 142.5, 1e-12);
  np_scene_eval_clear(&at);
}

/* A later track of a key that excludes another's wins, as a later --set does. */
static void the_later_of_two_excluding_tracks_wins(void **state) {
  fixture *f = *state;
  neph_scene at;
  assert_int_equal(np_scene_eval(f->scene, 1, &at), NEPH_OK);
  assert_true(at.sun.time.is_given);
  np_scene_eval_clear(&at);
  set(f, "animate.sun.azimuth", "[[1, 30 deg], [11, 40 deg]]");
  assert_int_equal(np_scene_eval(f->scene, 11, &at), NEPH_OK);
  assert_false(at.sun.time.is_given);
  assert_near(at.sun.azimuth_rad, 40.0 * 3.14159265358979323846 / 180.0, 1e-15);
  np_scene_eval_clear(&at);
}

static void the_scene_s_own_frame_is_set(void **state) {
  fixture *f = *state;
  neph_scene at;
  assert_int_equal(np_scene_eval(f->scene, 7, &at), NEPH_OK);
  char *expected = describe(&at);
  np_scene_eval_clear(&at);
  assert_int_equal(neph_scene_set_frame(f->scene, 4), NEPH_OK);
  assert_int_equal(neph_scene_set_frame(f->scene, 7), NEPH_OK);
  assert_described(f->scene, expected);
  set(f, "render.samples", "4"); /* reads all keys again */
  assert_described(f->scene, expected);
  neph_text_destroy(f->context, expected);
}

static neph_result attempt(neph_context *context, void *user) {
  neph_scene *scene, at;
  neph_result result = neph_scene_load_text(context, user, "dir/scene.yaml", &scene);
  if (result) return result;
  result = np_scene_eval(scene, 6, &at);
  np_scene_eval_clear(&at);
  if (!result) result = neph_scene_set_frame(scene, 5);
  neph_scene_destroy(scene);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  assert_survives_failed_allocations(attempt, (void *)(uintptr_t)animated);
}

/* ---- Two threads ---- */

static const char moving[] =
    "{camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 800 m], fov: 40 deg, resolution: [16, 10]},"
    " sun: {elevation: 30 deg, azimuth: 140 deg},"
    " clouds: [{name: a, bake: {preset: cumulus_mediocris, model: hero, seed: 3, extent: [800 m, 800 m], voxel: 80 "
    "m}}],"
    " animate: {camera.position: [[1, [0, -3 km, 400 m]], [11, [400 m, -2.6 km, 700 m]]],"
    " sun.elevation: [[1, 30 deg], [11, 50 deg]],"
    " \"clouds[0].position\": [[1, [0, 0, 600 m]], [11, [200 m, 0, 600 m]]]},"
    " render: {samples: 1, light_degree: 3}}";

static int set_up_moving(void **state) { return set_up_scene(state, 2, moving); }

typedef struct thread_picture {
  const neph_scene *scene;
  int frame;
  neph_image *image;
  neph_result result;
} thread_picture;

static void *render(void *user) {
  thread_picture *p = user;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  p->result = neph_scene_get_render_desc(p->scene, &desc);
  desc.frame = p->frame;
  if (!p->result) p->result = neph_render_image(p->scene, &desc, &p->image);
  return NULL;
}

/* Each picture has the bits that it has alone. */
static void two_threads_render_one_scene(void **state) {
  fixture *f = *state;
  thread_picture together[2], alone[2];
  pthread_t threads[2];
  char *before = describe(f->scene);
  for (int i = 0; i < 2; i++)
    together[i] = alone[i] = (thread_picture){.scene = f->scene, .frame = 3 + 5 * i, .result = NEPH_ERROR_INTERNAL};
  for (int i = 0; i < 2; i++) assert_int_equal(pthread_create(&threads[i], NULL, render, &together[i]), 0);
  for (int i = 0; i < 2; i++) assert_int_equal(pthread_join(threads[i], NULL), 0);
  for (int i = 0; i < 2; i++) {
    neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
    (void)render(&alone[i]);
    assert_int_equal(together[i].result, NEPH_OK);
    assert_int_equal(alone[i].result, NEPH_OK);
    assert_int_equal(neph_image_compare(f->context, together[i].image, alone[i].image, &difference), NEPH_OK);
    assert_int_equal(difference.differing_count, 0);
    neph_image_destroy(together[i].image);
    neph_image_destroy(alone[i].image);
  }
  assert_described(f->scene, before);
  neph_text_destroy(f->context, before);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_frame_is_a_scene_with_its_values, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_frame_can_be_evaluated_in_another, set_up, tear_down),
      cmocka_unit_test_setup_teardown(steps_stay_within_an_exposure, set_up, tear_down),
      cmocka_unit_test_setup_teardown(the_later_of_two_excluding_tracks_wins, set_up, tear_down),
      cmocka_unit_test_setup_teardown(the_scene_s_own_frame_is_set, set_up, tear_down),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test_setup_teardown(two_threads_render_one_scene, set_up_moving, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
