/* SPDX-License-Identifier: Apache-2.0 */
/* Tables over a sequence: what is kept, what is built anew and what the log says of it, and the error of keeping. */
#include <nephos/nephos.h>

#include "test_scenes.h"

static const char sea[] =
    "{camera: {position: [0, 0, 300 m], look_at: [0, 1 km, 400 m], fov: 90 deg, resolution: [32, 18]},"
    " sun: {elevation: 20 deg, azimuth: 40 deg}, render: {samples: 1}}";

static neph_image *render(const fixture *f) {
  neph_image *image;
  assert_int_equal(neph_renderer_render(f->renderer, f->scene, NULL, &image), NEPH_OK);
  return image;
}

static void assert_built(const fixture *f, bool atmosphere, bool sky, const char *reason) {
  assert_int_equal(strstr(f->log.text, "atmosphere: rebuilt") != NULL, atmosphere);
  assert_int_equal(strstr(f->log.text, "camera sky: rebuilt") != NULL, sky);
  if (reason) assert_non_null(strstr(f->log.text, reason));
}

static int set_up(void **state) {
  (void)set_up_scene(state, 2, sea);
  neph_image_destroy(render(*state));
  return 0;
}

static void the_first_picture_reuses_nothing(void **state) { assert_built(*state, false, false, NULL); }

static void a_camera_that_moves_a_metre_keeps_all(void **state) {
  render_changed(*state, "camera.position", "[1 m, 0, 301 m]");
  assert_built(*state, false, false, NULL);
  render_changed(*state, "camera.position", "[2 m, 1 m, 302 m]");
  assert_built(*state, false, false, NULL);
}

static void a_camera_that_climbs_gets_another_sky(void **state) {
  render_changed(*state, "camera.position", "[0, 0, 400 m]");
  assert_built(*state, false, true, ": the observer stands 100 m higher or lower");
}

static void a_sun_that_moves_a_thousandth_of_a_degree_keeps_all(void **state) {
  render_changed(*state, "sun.elevation", "20.001 deg");
  assert_built(*state, false, false, NULL);
}

static void a_sun_that_moves_a_degree_gets_another_sky(void **state) {
  render_changed(*state, "sun.elevation", "21 deg");
  assert_built(*state, false, true, ": the sun stands 1 degrees higher or lower");
}

/* Changes are counted from when the table was built: five small ones are one too large. */
static void small_steps_do_not_add_up_unseen(void **state) {
  for (int i = 1; i <= 5; i++) {
    char text[32];
    (void)snprintf(text, sizeof text, "%.4f deg", 20.0 + 0.001 * i);
    render_changed(*state, "sun.elevation", text);
    assert_built(*state, false, i == 4, NULL);
  }
}

static void haze_that_changes_gets_all_anew(void **state) {
  render_changed(*state, "atmosphere.mie_height", "1.5 km");
  assert_built(*state, true, true, ": the height of a layer changed by 20 %");
  render_changed(*state, "atmosphere.tolerance", "0.01");
  assert_built(*state, true, true, ": its tolerance changed");
}

/* Air over a sea knows its glint, which widens with the wind; a calm sea and back is the first picture again. */
static void wind_that_rises_gets_all_anew(void **state) {
  fixture *f = *state;
  render_changed(f, "water.wind", "2 m/s");
  neph_image *calm = render(f);
  render_changed(f, "water.wind", "12 m/s");
  assert_built(f, true, true, ": the water below it changed");
  neph_image *rough = render(f);
  render_changed(f, "water.wind", "2 m/s");
  neph_image *again = render(f);
  assert_memory_equal(neph_image_get_channel(calm, "G"), neph_image_get_channel(again, "G"), 32 * 18 * sizeof(float));
  assert_memory_not_equal(neph_image_get_channel(calm, "G"), neph_image_get_channel(rough, "G"),
                          32 * 9 * sizeof(float)); /* the sky */
  neph_image_destroy(calm);
  neph_image_destroy(rough);
  neph_image_destroy(again);
}

/* A traced atmosphere reuses existing tables, and builds no more than it needs: the march then builds the rest. */
static void traced_air_has_no_tables_of_light(void **state) {
  fixture *f = *state;
  render_changed(f, "render.integrator", "path");
  assert_built(f, false, false, NULL);
  set(f, "atmosphere.mie_height", "1.5 km");
  neph_image_destroy(render(f));
  render_changed(f, "render.integrator", "march");
  assert_built(f, true, true, ": what is asked of it changed");
}

static void a_change_of_the_suns_strength_keeps_all_and_counts(void **state) {
  fixture *f = *state;
  neph_image *bright = render(f);
  set(f, "sun.irradiance", "[0.737, 0.9252, 0.95599]");
  neph_image *half = render(f);
  assert_built(f, false, false, NULL);
  /* Half the light, to the rounding of halves in floats. */
  assert_near_relative((double)neph_image_get_channel(half, "G")[16],
                       0.5 * (double)neph_image_get_channel(bright, "G")[16], 1e-5);
  neph_image_destroy(bright);
  neph_image_destroy(half);
}

/* Relative rms difference of two pictures' greens. */
static double compare(neph_image *a, neph_image *b) {
  const float *x = neph_image_get_channel(a, "G"), *y = neph_image_get_channel(b, "G");
  double square = 0.0;
  for (int i = 0; i < 32 * 18; i++) square += pow((double)x[i] / (double)y[i] - 1.0, 2.0);
  return sqrt(square / (32 * 18));
}

/* A picture of kept tables against one of its own, at the ends of what is kept: the camera 8 m and the sun 0.0034
 * degrees from where they were, by day, at sunset and in twilight. The tolerance is the tables': 0.7 %. */
static void keeping_errs_less_than_the_tolerance(void **state) {
  static const double elevations[] = {20.0, 0.5, -6.0};
  fixture *f = *state;
  for (int i = 0; i < 3; i++) {
    char before[32], after[32];
    (void)snprintf(before, sizeof before, "%.4f deg", elevations[i]);
    (void)snprintf(after, sizeof after, "%.4f deg", elevations[i] + 0.0034);
    render_changed(f, "camera.position", "[0, 0, 300 m]");
    render_changed(f, "sun.elevation", before);
    set(f, "camera.position", "[0, 0, 308 m]");
    set(f, "sun.elevation", after);
    test_log_clear(&f->log);
    neph_image *kept = render(f);
    assert_built(f, false, false, NULL);
    neph_scene *fresh;
    assert_int_equal(neph_scene_load_text(f->context, sea, "sea", &fresh), NEPH_OK);
    assert_int_equal(neph_scene_set(fresh, "camera.position", "[0, 0, 308 m]"), NEPH_OK);
    assert_int_equal(neph_scene_set(fresh, "sun.elevation", after), NEPH_OK);
    neph_image *own;
    assert_int_equal(neph_render_image(fresh, NULL, &own), NEPH_OK);
    const double error = compare(kept, own);
    print_message("sun at %g degrees: a kept sky is %.3f %% off\n", elevations[i], 100.0 * error);
    assert_true(error <= 0.007);
    assert_true(error > 0.0);
    neph_image_destroy(kept);
    neph_image_destroy(own);
    neph_scene_destroy(fresh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(the_first_picture_reuses_nothing, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_camera_that_moves_a_metre_keeps_all, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_camera_that_climbs_gets_another_sky, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_sun_that_moves_a_thousandth_of_a_degree_keeps_all, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_sun_that_moves_a_degree_gets_another_sky, set_up, tear_down),
      cmocka_unit_test_setup_teardown(small_steps_do_not_add_up_unseen, set_up, tear_down),
      cmocka_unit_test_setup_teardown(haze_that_changes_gets_all_anew, set_up, tear_down),
      cmocka_unit_test_setup_teardown(wind_that_rises_gets_all_anew, set_up, tear_down),
      cmocka_unit_test_setup_teardown(traced_air_has_no_tables_of_light, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_change_of_the_suns_strength_keeps_all_and_counts, set_up, tear_down),
      cmocka_unit_test_setup_teardown(keeping_errs_less_than_the_tolerance, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
