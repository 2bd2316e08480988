/* SPDX-License-Identifier: Apache-2.0 */
/* Whole pictures: the same bits however the work is divided, components that add up, nothing left on failure. */
#include <stdlib.h>
#include <time.h>

#include <nephos/nephos.h>

#include "test_cumulus_scene.h"
#include "test_render_once.h"
#include "test_contexts.h"

/* Coarse tables of the air, and light in few directions: the work is divided over them as over finer ones. */
static const char scene_text[] = TEST_CUMULUS_SCENE
    "atmosphere: {tolerance: 0.1}\n"
    "render: {samples: 17, light_degree: 3, light_residual: 0.03}\n"
    "output: {color_space: bands,\n"
    "         aovs: [background, terrain, air, sun, sky, ground, multiple, transmittance, distance]}\n";

static neph_scene *load(neph_context *context) {
  neph_scene *scene = NULL;
  assert_int_equal(neph_scene_load_text(context, scene_text, "test.yaml", &scene), NEPH_OK);
  return scene;
}

static neph_image *render_in(neph_context *context, neph_integrator integrator, const unsigned crop[4]) {
  neph_scene *scene = load(context);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.integrator = integrator;
  for (int a = 0; crop && a < 2; a++) {
    desc.crop_min[a] = crop[a];
    desc.crop_max[a] = crop[2 + a];
  }
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return image;
}

/* Every stage is built. */
static neph_image *render(unsigned threads, neph_integrator integrator, const unsigned crop[4]) {
  return render_in(test_context_create(threads, NULL), integrator, crop);
}

/* Stages are those of the first such picture. */
static neph_image *render_cached(unsigned threads, neph_integrator integrator, const unsigned crop[4]) {
  return render_in(test_context_create_cached(threads, NULL), integrator, crop);
}

/* Every pixel of `part`, which lies at (x0, y0) of `whole`, bit for bit. */
static void assert_same_bits(neph_image *whole, neph_image *part, unsigned x0, unsigned y0) {
  const unsigned width = neph_image_get_width(part), stride = neph_image_get_width(whole);
  for (unsigned c = 0; c < neph_image_get_channel_count(whole); c++) {
    const char *name = neph_image_get_channel_name(whole, c);
    const float *a = neph_image_get_channel(whole, name), *b = neph_image_get_channel(part, name);
    for (unsigned y = 0; y < neph_image_get_height(part); y++)
      assert_memory_equal(a + (y0 + y) * stride + x0, b + y * width, width * sizeof *a);
  }
}

static void threads_change_no_bit(void **state) {
  (void)state;
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_image *one = render(1, i, NULL), *two = render(2, i, NULL), *five = render(5, i, NULL);
    assert_same_bits(one, two, 0, 0);
    assert_same_bits(one, five, 0, 0);
    neph_image_destroy(one);
    neph_image_destroy(two);
    neph_image_destroy(five);
  }
}

/* The stages of the first tile, built for it, serve the others. */
static void tiles_make_up_the_whole(void **state) {
  (void)state;
  static const unsigned crops[4][4] = {{0, 0, 11, 5}, {11, 0, 24, 5}, {0, 5, 11, 16}, {11, 5, 24, 16}};
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_image *whole = render(2, i, NULL);
    for (int t = 0; t < 4; t++) {
      neph_image *tile = render_cached(1, i, crops[t]);
      assert_same_bits(whole, tile, crops[t][0], crops[t][1]);
      neph_image_destroy(tile);
    }
    neph_image_destroy(whole);
  }
}

/* Each component went through its own film; sums of 7 floats agree with the beauty's to float rounding. */
static void components_add_up_to_the_beauty(void **state) {
  (void)state;
  static const char *const layers[] = {"background", "terrain", "air", "sun", "sky", "ground", "multiple"};
  static const char *const bands[] = {"R", "G", "B"};
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_image *image = render_cached(2, i, NULL);
    const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
    double lit[7] = {0};
    for (int b = 0; b < 3; b++)
      for (size_t p = 0; p < count; p++) {
        double sum = 0;
        for (int l = 0; l < 7; l++) {
          char name[32];
          (void)snprintf(name, sizeof name, "%s.%s", layers[l], bands[b]);
          const double value = (double)neph_image_get_channel(image, name)[p];
          assert_true(value >= 0.0);
          lit[l] += value;
          sum += value;
        }
        assert_near_relative((double)neph_image_get_channel(image, bands[b])[p], sum, 1e-5);
      }
    /* The march's light from the ground is what shines through a cloud by its forward peak: none stands before it. */
    for (int l = 0; l < 7; l++) assert_true(lit[l] > 0.0 || (i == NEPH_INTEGRATOR_MARCH && l == 5));
    neph_image_destroy(image);
  }
}

static void depth_is_finite_on_ground_and_infinite_in_the_sky(void **state) {
  (void)state;
  neph_image *image = render_cached(2, NEPH_INTEGRATOR_MARCH, NULL);
  const float *depth = neph_image_get_channel(image, "Z"), *distance = neph_image_get_channel(image, "distance");
  const float *alpha = neph_image_get_channel(image, "A");
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  int near = 0, far = 0;
  for (size_t p = 0; p < count; p++) {
    if (isinf(depth[p])) {
      far++;
    } else {
      assert_true(depth[p] > 0.0f && depth[p] <= distance[p] * 1.00001f);
      near++;
    }
    assert_true(alpha[p] >= 0.0f && alpha[p] <= 1.0f);
  }
  assert_true(near > 10 && far > 10);
  neph_image_destroy(image);
}

/* The scene by the tracer, with its standard error, under a seed. */
static neph_image *render_with_errors(neph_context *context, uint64_t seed) {
  neph_scene *scene = load(context);
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[standard_error]"), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.integrator = NEPH_INTEGRATOR_PATH;
  desc.sample_count = 64;
  desc.seed = seed;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Header values of the mean of G and its standard error against the channels: six digits are printed. */
static void assert_mean_is_stated(neph_image *image) {
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  const float *green = neph_image_get_channel(image, "G"), *error = neph_image_get_channel(image, "standard_error.G");
  double sum = 0, variance = 0, stated[3];
  for (size_t p = 0; p < count; p++) {
    sum += (double)green[p];
    variance += (double)error[p] * (double)error[p];
  }
  const char *mean = neph_image_get_attribute(image, "nephos:mean");
  assert_int_equal(sscanf(mean, "%lf %lf %lf", &stated[0], &stated[1], &stated[2]), 3);
  assert_near_relative(stated[1], sum / (double)count, 2e-5);
  const char *mean_error = neph_image_get_attribute(image, "nephos:meanStandardError");
  assert_int_equal(sscanf(mean_error, "%lf %lf %lf", &stated[0], &stated[1], &stated[2]), 3);
  assert_near_relative(stated[1], sqrt(variance) / (double)count, 2e-5);
}

/* Two pictures that differ only in their seed differ by their stated errors: the mean of (a − b)²/(e² + f²) is 1, less
 * what spreading the samples over the pixel saves, which is more for edges than for noise; above 1 by chance and by
 * rare bright paths, which 64 samples may miss. */
static void standard_errors_are_what_seeds_differ_by(void **state) {
  (void)state;
  neph_context *context = test_context_create_cached(2, NULL);
  neph_image *one = render_with_errors(context, 1), *two = render_with_errors(context, 2);
  const float *a = neph_image_get_channel(one, "G"), *e = neph_image_get_channel(one, "standard_error.G");
  const float *b = neph_image_get_channel(two, "G"), *f = neph_image_get_channel(two, "standard_error.G");
  const size_t count = (size_t)neph_image_get_width(one) * neph_image_get_height(one);
  double sum = 0;
  for (size_t p = 0; p < count; p++) {
    const double difference = (double)a[p] - (double)b[p];
    assert_true(e[p] >= 0.0f);
    sum += difference * difference / fmax((double)e[p] * (double)e[p] + (double)f[p] * (double)f[p], 1e-30);
  }
  print_message("mean of (a - b)^2 over the variance stated: %.3f\n", sum / (double)count);
  assert_true(sum / (double)count > 0.2 && sum / (double)count < 1.3);
  assert_mean_is_stated(one);
  neph_image_destroy(one);
  neph_image_destroy(two);
  neph_context_destroy(context);
}

static bool stop_when_rendering(void *user, const neph_progress *progress) {
  struct timespec *asked = user;
  if (strcmp(progress->stage, "rendering") != 0) return true;
  if (asked->tv_sec == 0) (void)clock_gettime(CLOCK_MONOTONIC, asked);
  return false;
}

static void cancelling_takes_less_than_half_a_second(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_scene *scene = load(context);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  struct timespec asked = {0}, end;
  desc.integrator = NEPH_INTEGRATOR_PATH;
  desc.sample_count = 100000;
  desc.progress = stop_when_rendering;
  desc.progress_user = &asked;
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_ERROR_CANCELLED);
  (void)clock_gettime(CLOCK_MONOTONIC, &end);
  assert_null(image);
  assert_true(asked.tv_sec != 0);
  assert_true((double)(end.tv_sec - asked.tv_sec) + 1e-9 * (double)(end.tv_nsec - asked.tv_nsec) < 0.5);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

static void bad_descriptions_are_refused(void **state) {
  (void)state;
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_scene *scene = load(context);
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  desc.width = 0;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "0 x 540");
  desc = (neph_render_desc)NEPH_RENDER_DESC_DEFAULT;
  desc.crop_max[0] = 961;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "961", "960 x 540");
  desc = (neph_render_desc)NEPH_RENDER_DESC_DEFAULT;
  desc.sample_count = 0;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "samples is 0");
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[standard_error]"), NEPH_OK);
  desc.sample_count = 1;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&log, "samples is 1", "standard_error");
  assert_null(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

/* Light is a number that is not negative, whatever the camera sees of ground, clouds and sky. */
static void assert_sees_numbers(neph_scene *scene, const char *place) {
  static const char *const bands[] = {"R", "G", "B", "A"};
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  for (int b = 0; b < 4; b++)
    for (size_t p = 0; p < count; p++) {
      const float value = neph_image_get_channel(image, bands[b])[p];
      if (!(value >= 0.0f && isfinite(value))) fail_msg("%s: %s is %g", place, bands[b], (double)value);
    }
  neph_image_destroy(image);
}

/* Renders from a position under clouds and hills, or without air; a message says whether it is below ground. */
static void look_from(neph_scene *scene, test_log *log, const char *place, bool is_buried) {
  static const char *const settings[][2] = {{"render.integrator", "march"},
                                            {"render.integrator", "path"},
                                            {"atmosphere", "none"},
                                            {"render.integrator", "march"},
                                            {"atmosphere", "{tolerance: 0.1}"}};
  assert_int_equal(neph_scene_set(scene, "camera.position", place), NEPH_OK);
  for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
    test_log_clear(log);
    assert_int_equal(neph_scene_set(scene, settings[i][0], settings[i][1]), NEPH_OK);
    assert_sees_numbers(scene, place);
    if ((strstr(log->text, "below the ground") != NULL) != is_buried) fail_msg("%s: %s", place, log->text);
  }
}

/* Covers the planet's centre, where no direction is up, the poles, a point of the sphere, and the ends of the allowed
 * range. */
static void a_camera_anywhere_sees_numbers(void **state) {
  (void)state;
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create_cached(2, &log);
  neph_scene *scene = load(context);
  assert_int_equal(neph_scene_set(scene, "render.samples", "2"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "camera.resolution", "[12, 8]"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[]"), NEPH_OK);
  look_from(scene, &log, "[0 m, 0 m, -6360 km]", true);
  look_from(scene, &log, "[0 m, 0 m, -6359999.999 m]", true);
  look_from(scene, &log, "[0 m, 0 m, -12719 km]", true);
  look_from(scene, &log, "[30 km, 0 m, -1 km]", true);
  look_from(scene, &log, "[0 m, 0 m, -1 m]", true);
  look_from(scene, &log, "[0 m, 0 m, -12720 km]", false);
  look_from(scene, &log, "[0 m, 6360 km, -6360 km]", false);
  look_from(scene, &log, "[0 m, 0 m, 1000000 km]", false);
  look_from(scene, &log, "[-1000000 km, 1000000 km, -1000000 km]", false);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

/* A scene small enough to fail each of its allocations in turn; the ordinates fail in test_scattering_field. */
static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  static char text[] = "version: 1\n"
                       "camera: {position: [0 m, -200 m, 5 m], look_at: [0 m, 0 m, 60 m], resolution: [2, 2]}\n"
                       "atmosphere: {preset: none}\n"
                       "clouds: [{name: puff, bake: {extent: [100 m, 100 m], base: 20 m, thickness: 100 m, "
                       "voxel: 20 m, coverage: 1}}]\n"
                       "render: {samples: 1, multiple_scattering: octaves}\n";
  assert_survives_failed_allocations(test_render_once, text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(tiles_make_up_the_whole),
      cmocka_unit_test(components_add_up_to_the_beauty),
      cmocka_unit_test(depth_is_finite_on_ground_and_infinite_in_the_sky),
      cmocka_unit_test(standard_errors_are_what_seeds_differ_by),
      cmocka_unit_test(cancelling_takes_less_than_half_a_second),
      cmocka_unit_test(bad_descriptions_are_refused),
      cmocka_unit_test(a_camera_anywhere_sees_numbers),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
