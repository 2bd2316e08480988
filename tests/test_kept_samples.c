/* SPDX-License-Identifier: Apache-2.0 */
/* A renderer that goes on with the samples of its last picture. */
#include <nephos/nephos.h>

#include <stdlib.h>

#include "test_scenes.h"

static const char text[] =
    "camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 1200 m], fov: 50 deg, resolution: [40, 24]}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
    "clouds: [{name: a, bake: {preset: cumulus_mediocris, seed: 3, extent: [3 km, 3 km], voxel: 100 m}}]\n"
    "terrain: {ridges: {samples: 65, relief: 400 m}}\n"
    "atmosphere: {tolerance: 0.1}\n"
    "render: {samples: 1, multiple_scattering: none}\n"
    "output: {pixel_type: float, aovs: [clouds, variance, mattes, optical_depth]}\n";

static int set_up(void **state) {
  const int failed = set_up_scene_verbose(state, 2, text);
  const fixture *f = *state;
  return failed || neph_renderer_keep_samples(f->renderer, true);
}

static neph_render_desc describe(const fixture *f, unsigned samples) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.sample_count = samples;
  desc.detail_height = desc.height;
  return desc;
}

static void assert_bits_from_the_start(const fixture *f, const neph_render_desc *desc, const neph_image *image) {
  neph_image *alone;
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_render_image(f->scene, desc, &alone), NEPH_OK);
  assert_int_equal(neph_image_compare(f->context, image, alone, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  assert_string_equal(neph_image_get_attribute(image, "nephos:noise"), neph_image_get_attribute(alone, "nephos:noise"));
  neph_image_destroy(alone);
}

/* Renders with the renderer; the picture has the bits of one from the start. */
static void render(fixture *f, const neph_render_desc *desc) {
  neph_image *image;
  test_log_clear(&f->log);
  assert_int_equal(neph_renderer_render(f->renderer, f->scene, desc, &image), NEPH_OK);
  assert_bits_from_the_start(f, desc, image);
  neph_image_destroy(image);
}

/* CPU seconds of the integrator in the last picture, by the log. */
static double get_integrator_s(const fixture *f) {
  const char *at = strstr(f->log.text, "integrator: predicted");
  assert_non_null(at);
  at = strstr(at, "measured ");
  assert_non_null(at);
  return strtod(at + strlen("measured "), NULL);
}

/* Numbers within a leaf of the film's tree, at its end, and over several nodes. */
static void more_samples_have_the_bits_of_all_at_once(void **state) {
  fixture *f = *state;
  static const unsigned counts[] = {2, 3, 7, 16, 24, 40, 48, 49, 100};
  for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
    const neph_render_desc desc = describe(f, counts[i]);
    render(f, &desc);
  }
}

static void samples_that_are_kept_are_not_taken_again(void **state) {
  fixture *f = *state;
  neph_image *image;
  double first_s = 0.0;
  for (unsigned samples = 240; samples <= 256; samples += 16) {
    const neph_render_desc desc = describe(f, samples);
    test_log_clear(&f->log);
    assert_int_equal(neph_renderer_render(f->renderer, f->scene, &desc, &image), NEPH_OK);
    neph_image_destroy(image);
    if (samples == 256) assert_null(strstr(f->log.text, "rebuilt"));
    if (samples == 240) first_s = get_integrator_s(f);
    /* A sixteenth of the samples, and the distance of each pixel, which is measured once a picture. */
    if (samples == 256) assert_true(get_integrator_s(f) < 0.5 * first_s);
  }
}

static void another_picture_begins_anew(void **state) {
  fixture *f = *state;
  neph_render_desc desc = describe(f, 4);
  render(f, &desc);
  set(f, "sun.elevation", "33 deg");
  desc.sample_count = 8;
  render(f, &desc);
  desc.sample_count = 2; /* fewer than it has */
  render(f, &desc);
  desc.seed = 7;
  render(f, &desc);
  desc.crop_min[0] = 8, desc.crop_max[1] = 17;
  render(f, &desc);
  desc.sample_count = 20;
  render(f, &desc);
  desc.target_error = 0.2; /* whose pixels have numbers of their own */
  render(f, &desc);
  desc.target_error = NEPH_UNLIMITED;
  render(f, &desc);
}

static bool stop_late(void *user, const neph_progress *progress) {
  (void)user;
  return strcmp(progress->stage, "rendering") != 0 || progress->fraction < 0.5;
}

static void a_picture_goes_on_after_a_cancel(void **state) {
  fixture *f = *state;
  neph_image *image;
  neph_render_desc desc = describe(f, 5);
  render(f, &desc);
  desc.sample_count = 300;
  desc.progress = stop_late;
  assert_int_equal(neph_renderer_render(f->renderer, f->scene, &desc, &image), NEPH_ERROR_CANCELLED);
  desc.progress = NULL;
  render(f, &desc);
}

static void a_renderer_may_stop_to_keep_them(void **state) {
  fixture *f = *state;
  neph_render_desc desc = describe(f, 4);
  render(f, &desc);
  assert_int_equal(neph_renderer_keep_samples(f->renderer, false), NEPH_OK);
  desc.sample_count = 8;
  render(f, &desc);
}

#define KEPT_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      KEPT_TEST(more_samples_have_the_bits_of_all_at_once),
      KEPT_TEST(samples_that_are_kept_are_not_taken_again),
      KEPT_TEST(another_picture_begins_anew),
      KEPT_TEST(a_picture_goes_on_after_a_cancel),
      KEPT_TEST(a_renderer_may_stop_to_keep_them),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
