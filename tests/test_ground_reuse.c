/* SPDX-License-Identifier: Apache-2.0 */
/* Light on the ground under clouds and between hills, from picture to picture: gathered anew where it changes, and
 * nowhere else. */
#include <nephos/nephos.h>

#include "test_scenes.h"

static const char text[] =
    "camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 800 m], fov: 50 deg, resolution: [48, 32]}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
    "clouds: [{name: a, bake: {preset: cumulus_mediocris, seed: 3, extent: [3 km, 3 km], voxel: 100 m}}]\n"
    "terrain: {ridges: {samples: 65, relief: 400 m}}\n"
    "render: {samples: 1}\n"
    "output: {pixel_type: float}\n";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, text); }

static void assert_same_bits(fixture *f, const neph_image *image) {
  neph_image *alone;
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_render_image(f->scene, NULL, &alone), NEPH_OK);
  assert_int_equal(neph_image_compare(f->context, image, alone, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  neph_image_destroy(alone);
}

/* Renders after an edit; the log says whether the light on the ground and between hills is reused. */
static neph_image *render_after(fixture *f, const char *key, const char *value, bool is_reused) {
  neph_image *image;
  test_log_clear(&f->log);
  set(f, key, value);
  assert_int_equal(neph_renderer_render(f->renderer, f->scene, NULL, &image), NEPH_OK);
  static const char *const parts[] = {"clouds on ground: reused", "relief light: reused"};
  for (int i = 0; i < 2; i++)
    if ((strstr(f->log.text, parts[i]) != NULL) != is_reused) fail_msg("%s: %s", key, f->log.text);
  return image;
}

static void a_camera_that_moves_keeps_it_to_the_bit(void **state) {
  fixture *f = *state;
  static const char *const places[] = {"[0, -6 km, 900 m]", "[0, -6 km, 950 m]", "[80 m, -5.95 km, 900 m]"};
  for (int i = 0; i < 3; i++) {
    neph_image *image = render_after(f, "camera.position", places[i], i > 0);
    assert_non_null(strstr(f->log.text, i ? "multiple scattering: reused" : "multiple scattering: built"));
    assert_same_bits(f, image);
    neph_image_destroy(image);
  }
}

/* Edits that change the light on the ground, or may: those of the sun, the clouds, the ground and the air. */
static void what_it_depends_on_gathers_it_anew(void **state) {
  fixture *f = *state;
  static const char *const edits[][2] = {
      {"sun.elevation", "31 deg"},        {"sun.irradiance", "[1.474, 1.8504, 1.9119]"}, {"terrain.albedo", "0.3"},
      {"terrain.ridges.relief", "420 m"}, {"clouds[0].position", "[100 m, 0, 1300 m]"},  {"clouds[0].albedo", "0.99"},
      {"atmosphere.mie_height", "1.3 km"}};
  neph_image_destroy(render_after(f, "sun.elevation", "30 deg", false));
  neph_image_destroy(render_after(f, "output.exposure", "1", true));
  neph_image_destroy(render_after(f, "camera.fov", "49 deg", true));
  for (size_t i = 0; i < sizeof edits / sizeof *edits; i++)
    neph_image_destroy(render_after(f, edits[i][0], edits[i][1], false));
  neph_image_destroy(render_after(f, "camera.fov", "50 deg", true));
}

#define GROUND_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      GROUND_TEST(a_camera_that_moves_keeps_it_to_the_bit),
      GROUND_TEST(what_it_depends_on_gathers_it_anew),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
