/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds that multiple scattering is not solved for: the plan says which and why, and the picture changes by less than
 * it states. A picture of a scene with a track, whose plan leaves out none, is the one to compare with. */
#include <math.h>

#include "test_support.h"

#include "plan/plan.h"
#include "plan/plan_choices.h"

#define VIEW "camera: {position: [0, -3 km, 900 m], look_at: [0, 0, 900 m], fov: 40 deg, resolution: [32, 18]}\n"
#define DAY VIEW "sun: {elevation: 40 deg, azimuth: 140 deg}\nrender: {samples: 4}\noutput: {color_space: bands}\n"
#define SHAPE "model: hero, seed: 3, voxel: 60 m, extent: [600 m, 600 m]"
#define SEEN "{name: seen, bake: {" SHAPE "}}"
#define BEHIND "{name: behind, bake: {" SHAPE ", center: [0, -24 km]}}"
#define NEAR "{name: near, bake: {" SHAPE ", center: [0, -5 km]}}"
#define BLACK "{name: black, albedo: 0, bake: {" SHAPE "}}"
#define NEARLY_BLACK "{name: black, albedo: 1e-30, bake: {" SHAPE "}}"
#define WHOLE "animate: {camera.fov: [[1, 40 deg], [9, 40 deg]]}\n"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

static neph_scene *load(test_fixture *f, const char *text) {
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, text, "test.yaml", &scene)) fail_msg("%s: %s", text, f->log.text);
  return scene;
}

static np_left_out choose(test_fixture *f, const char *text, const char *word) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  const np_left_out out = plan.decisions.left_out;
  const char *reason = plan.decisions.stages[NP_STAGE_ORDINATES].reason;
  if (!strstr(reason, word)) fail_msg("%s: \"%s\" is not in \"%s\"", text, word, reason);
  np_plan_clear(&plan);
  neph_scene_destroy(scene);
  return out;
}

static void the_plan_says_which_are_left_out(void **state) {
  test_fixture *f = *state;
  np_left_out out = choose(f, DAY "clouds: [" SEEN ", " BEHIND "]\n", "not for 1 of 2 clouds, out of view");
  assert_int_equal(out.clouds, 2);
  assert_true(!out.is_all && out.share > 0.0 && out.share < 0.01);
  out = choose(f, DAY "clouds: [" BEHIND "]\n", "the clouds are out of view");
  assert_true(out.is_all && !out.are_black);
  out = choose(f, DAY "clouds: [" BLACK "]\n", "albedo is 0");
  assert_true(out.is_all && out.are_black);
  assert_int_equal(choose(f, DAY "clouds: [" BLACK ", " SEEN "]\n", "solved for once").clouds, 0);
  assert_int_equal(choose(f, DAY "clouds: [" SEEN ", " NEAR "]\n", "solved for once").clouds, 0);
  assert_int_equal(choose(f, DAY WHOLE "clouds: [" SEEN ", " BEHIND "]\n", "solved for once").clouds, 0);
  assert_int_equal(choose(f, DAY "water: {}\nclouds: [" SEEN ", " BEHIND "]\n", "solved for once").clouds, 0);
}

/* A low sun behind the camera throws the shadow of the cloud there towards the other. */
static void a_cloud_that_shades_another_is_solved_for(void **state) {
  static const char sun[] = "sun: {elevation: 1 deg, azimuth: 180 deg}\n";
  char text[1024];
  (void)snprintf(text, sizeof text, VIEW "%sclouds: [" SEEN ", " BEHIND "]\n", sun);
  assert_int_equal(choose(*state, text, "solved for once").clouds, 0);
}

static neph_image *render(test_fixture *f, const char *text) {
  neph_scene *scene = load(f, text);
  neph_image *image = NULL;
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s: %s", text, f->log.text);
  neph_scene_destroy(scene);
  return image;
}

/* Differences of two pictures over their mean, in the worst of the channels. */
typedef struct difference {
  double rms, mean;
} difference;

static difference compare(test_fixture *f, const char *text, const char *whole_text) {
  neph_image *image = render(f, text), *whole = render(f, whole_text);
  static const char *const names[] = {"R", "G", "B"};
  enum { PIXELS = 32 * 18 };
  difference worst = {0.0, 0.0};
  for (int c = 0; c < 3; c++) {
    const float *a = neph_image_get_values(image, names[c]), *b = neph_image_get_values(whole, names[c]);
    assert_true(a && b);
    double squares = 0.0, off = 0.0, sum = 0.0;
    for (int i = 0; i < PIXELS; i++) {
      squares += pow((double)a[i] - (double)b[i], 2.0) / PIXELS;
      off += ((double)a[i] - (double)b[i]) / PIXELS;
      sum += (double)b[i] / PIXELS;
    }
    worst.rms = fmax(worst.rms, sqrt(squares) / sum);
    worst.mean = fmax(worst.mean, fabs(off) / sum);
  }
  neph_image_destroy(image);
  neph_image_destroy(whole);
  return worst;
}

/* Clouds that are left out change a picture by less than the plan states. Beside another cloud they change its cells
 * too, which are no longer spread over both: by less than the 2 % that those err by, which do not change its mean. */
static void pictures_change_by_less_than_is_stated(void **state) {
  test_fixture *f = *state;
  static const char alone[] = DAY "clouds: [" BEHIND "]\n", whole_alone[] = DAY WHOLE "clouds: [" BEHIND "]\n";
  static const char beside[] = DAY "clouds: [" SEEN ", " BEHIND "]\n",
                    whole_beside[] = DAY WHOLE "clouds: [" SEEN ", " BEHIND "]\n";
  const double alone_share = choose(f, alone, "out of view").share,
               beside_share = choose(f, beside, "out of view").share;
  const difference alone_off = compare(f, alone, whole_alone), beside_off = compare(f, beside, whole_beside);
  print_message("alone %.2g of %.2g, beside another %.2g of %.2g, %.2g rms\n", alone_off.rms, alone_share,
                beside_off.mean, beside_share, beside_off.rms);
  assert_true(alone_off.rms <= alone_share);
  assert_true(beside_off.mean <= beside_share);
  assert_true(beside_off.rms <= beside_share + 0.02);
}

/* Pictures of black clouds are those of clouds that are nearly black, for which light is solved for: the ground's shade
 * of the sky included. */
static void black_clouds_keep_their_pictures(void **state) {
  const difference off = compare(*state, DAY "clouds: [" BLACK "]\n", DAY "clouds: [" NEARLY_BLACK "]\n");
  assert_true(off.rms < 1e-6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(the_plan_says_which_are_left_out, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_that_shades_another_is_solved_for, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(pictures_change_by_less_than_is_stated, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(black_clouds_keep_their_pictures, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
