/* SPDX-License-Identifier: Apache-2.0 */
/* Samples by a target error: the rule of their number, and pictures by it: noise, bias, and bits. */
#include <stdlib.h>

#include <nephos/nephos.h>

#include "frame/sample_counts.h"
#include "test_support.h"

/* ---- The rule ---- */

enum { SIDE = 3, PILOTS = SIDE * SIDE, MIDDLE = 4 };

static const np_sample_rule plain = {
    .first = 1, .min = 1, .max = 1000, .gain = 100.0, .power = 0.5, .dim = 1e-3, .usual_spread = 1.0};

static double estimate(const np_sample_rule *rule, const float means[PILOTS], float squares, float count) {
  np_pilot pilots[PILOTS];
  for (int k = 0; k < PILOTS; k++) pilots[k] = (np_pilot){means[k], squares, count};
  return np_sample_rule_estimate_spread(rule, &pilots[MIDDLE], SIDE);
}

/* A constant has no noise; of a plane of slope s each way there is the tent's within a pixel, s²/6 each way. The
 * pixel's own value, 99, is never read. Tolerances: floats of six digits. */
static void spread_of_single_samples_is_what_no_plane_explains(void **state) {
  (void)state;
  static const float constant[] = {2, 2, 2, 2, 99, 2, 2, 2, 2};
  static const float plane[] = {7.0f, 8.0f, 9.0f, 9.0f, 99, 11.0f, 11.0f, 12.0f, 13.0f};
  static const float edge[] = {1, 1, 1, 1, 99, 1, 100, 100, 100};
  static const float dark[] = {0, 0, 0, 0, 99, 0, 0, 0, 0};
  assert_near(estimate(&plain, constant, 0.0f, 1.0f), 0.0, 1e-12);
  assert_near_relative(estimate(&plain, plane, 0.0f, 1.0f), (1.0 + 4.0) / 6.0 / 100.0, 1e-5);
  assert_near(estimate(&plain, dark, 0.0f, 1.0f), 0.0, 1e-12);
  assert_true(estimate(&plain, edge, 0.0f, 1.0f) <= 99.0 * 99.0 / 400.0 * (1.0 + 1e-6));
}

/* Four samples whose squares about their mean 2 are 3 in sum: the variance is 1, over 2² a quarter, which the contrast
 * of neighbours must allow. With as much weight for the usual spread as for the neighbours' 24 degrees it is the mean
 * of both, less the share of a quiet place, 2 % of 1 in 0.25. */
static void spread_of_pilots_is_that_about_their_means(void **state) {
  (void)state;
  static const float means[] = {2, 2, 2, 2, 99, 2, 2, 6, 1};
  np_sample_rule rule = plain;
  rule.first = 4;
  assert_near_relative(estimate(&rule, means, 3.0f, 4.0f), 0.25, 1e-6);
  rule.usual_freedom = 24.0;
  assert_near_relative(estimate(&rule, means, 3.0f, 4.0f), 0.5 * (0.25 + 0.25 / 0.27), 1e-6);
}

/* N = (gain·(σ/T)²)^power between its ends, and whole numbers whose mean it is. */
static void numbers_follow_the_spread(void **state) {
  (void)state;
  np_sample_rule rule = plain;
  assert_near_relative(np_sample_rule_count(&rule, 0.25), 5.0, 1e-12);
  assert_near_relative(np_sample_rule_count(&rule, 1e-9), 1.0, 0.0);
  assert_near_relative(np_sample_rule_count(&rule, 1e9), 1000.0, 0.0);
  rule.gain = 0.0;
  assert_near_relative(np_sample_rule_count(&rule, 1e9), 1.0, 0.0);
  double sum = 0.0;
  for (int i = 0; i < 1000; i++) sum += np_sample_rule_round(3.7, (i + 0.5) / 1000.0);
  assert_near(sum / 1000.0, 3.7, 1e-9);
}

/* ---- Pictures ---- */

/* A cloud in the void; cells of multiple scattering are coarse. */
#define SCENE_OF(bake, width, height, integrator, radiance)                                                            \
  "camera: {position: [0 m, -3 km, 1100 m], look_at: [0 m, 0 m, 1500 m], fov: 60 deg, resolution: [" width ", " height \
  "]}\n"                                                                                                               \
  "sun: {elevation: 50 deg, azimuth: 110 deg}\n"                                                                       \
  "atmosphere: {preset: none}\n"                                                                                       \
  "environment: {planet: none, radiance: " radiance "}\n"                                                              \
  "clouds:\n"                                                                                                          \
  "  - name: cumulus\n"                                                                                                \
  "    bake: {" bake "}\n"                                                                                             \
  "    albedo: 0.9\n"                                                                                                  \
  "    phase: {hg: 0.6}\n"                                                                                             \
  "render: {samples: 1, integrator: " integrator ", multiple_scattering: octaves}\n"                                   \
  "output: {aovs: [sample_count]}\n"

#define SCENE(width, height, integrator, radiance)                                                                     \
  SCENE_OF("preset: cumulus_mediocris, seed: 4, extent: [3 km, 3 km], base: 1200 m, voxel: 90 m, coverage: 0.6",       \
           width, height, integrator, radiance)

/* A ball without billows or wisps, with sky about it on all sides. */
#define BALL                                                                                                           \
  "model: thermals, extent: [3 km, 3 km], base: 1100 m, thickness: 900 m, voxel: 90 m, extinction: 0.1 1/m, "          \
  "billowiness: 0, erosion: 0, wispiness: 0, turbulence: 0, shape: {spheres: [[0 m, 0 m, 400 m, 400 m]]}"

typedef struct order {
  double target;
  unsigned samples, threads, tile, tile_count;
  uint64_t seed;
  const char *part, *checkpoint;
  bool is_resumed;
} order;

static neph_image *render(neph_scene *scene, const order *o) {
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.target_error = o->target > 0.0 ? o->target : NEPH_UNLIMITED;
  if (o->samples) desc.sample_count = o->samples;
  desc.seed = o->seed;
  desc.tile_index = o->tile;
  desc.tile_count = o->tile_count ? o->tile_count : 1;
  desc.part_path = o->part;
  desc.checkpoint_path = o->checkpoint;
  desc.is_resumed = o->is_resumed;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  return image;
}

static neph_scene *load(neph_context *context, const char *text) {
  neph_scene *scene = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  return scene;
}

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

static double get_number(const neph_image *image, const char *name) {
  const char *text = neph_image_get_attribute(image, name);
  assert_non_null(text);
  return strtod(text, NULL);
}

/* Measured noise, from pictures of two seeds relative to a reference, over the target. */
static double measure_noise(test_fixture *f, const char *text, double target, unsigned reference_samples) {
  neph_scene *scene = load(f->context, text);
  neph_image *first = render(scene, &(order){.target = target, .seed = 1}),
             *second = render(scene, &(order){.target = target, .seed = 2}),
             *reference = render(scene, &(order){.samples = reference_samples, .seed = 3});
  neph_image_difference d = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare_seeds(f->context, first, second, reference, &d), NEPH_OK);
  const double asked = get_number(first, "nephos:targetNoise");
  neph_image_destroy(first);
  neph_image_destroy(second);
  neph_image_destroy(reference);
  neph_scene_destroy(scene);
  print_message("noise over the one asked for: %.3f\n", d.pixel_noise.value / asked);
  return d.pixel_noise.value / asked;
}

/* Tolerance: a factor of 1.35, twice the standard error that 200 to 500 pilots leave where few pixels, a cloud's edge,
 * have most of the noise. Before black the noise of pixels that hold hardly any cloud has no bound, and pilots see
 * those that were hit as more than there are: there it may be lower. */
static void noise_is_the_one_asked_for(void **state) {
  test_fixture *f = *state;
  assert_in_range((int)(1000.0 * measure_noise(f, SCENE("64", "48", "march", "0.02"), 0.06, 16)), 740, 1350);
  assert_in_range((int)(1000.0 * measure_noise(f, SCENE("64", "48", "march", "0.02"), 0.03, 16)), 740, 1350);
  assert_in_range((int)(1000.0 * measure_noise(f, SCENE("32", "24", "path", "0.02"), 0.4, 64)), 740, 1350);
  assert_in_range((int)(1000.0 * measure_noise(f, SCENE("64", "48", "march", "0"), 0.06, 16)), 300, 1350);
}

enum { WIDTH = 16, HEIGHT = 10, PIXELS = WIDTH * HEIGHT, PICTURES = 16 };

/* The mean over many seeds is that of many samples for all, to 3 standard errors: of the picture, and of its bright and
 * its dark half, in which a number of samples that follows their own values would be wrong first. */
static void many_pictures_have_no_bias(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f->context, SCENE("16", "10", "path", "0.02"));
  neph_image *even = render(scene, &(order){.samples = 512, .seed = 1000});
  const float *reference = neph_image_get_channel(even, "G");
  double sum[2] = {0.0, 0.0}, squares[2] = {0.0, 0.0}, expected[2] = {0.0, 0.0}, mean = 0.0;
  for (int i = 0; i < PIXELS; i++) mean += (double)reference[i] / PIXELS;
  for (int i = 0; i < PIXELS; i++) expected[(double)reference[i] > mean] += (double)reference[i];
  for (unsigned k = 0; k < PICTURES; k++) {
    neph_image *image = render(scene, &(order){.target = 1.0, .seed = 1 + k});
    const float *g = neph_image_get_channel(image, "G");
    double own[2] = {0.0, 0.0};
    for (int i = 0; i < PIXELS; i++) own[(double)reference[i] > mean] += (double)g[i];
    for (int h = 0; h < 2; h++) {
      sum[h] += own[h] / PICTURES;
      squares[h] += own[h] * own[h] / PICTURES;
    }
    neph_image_destroy(image);
  }
  const double error_even = get_number(even, "nephos:meanStandardError") * PIXELS;
  for (int h = 0; h < 2; h++) {
    const double error = sqrt((squares[h] - sum[h] * sum[h]) / (PICTURES - 1));
    assert_near(sum[h], expected[h], 3.0 * hypot(error, error_even));
  }
  neph_image_destroy(even);
  neph_scene_destroy(scene);
}

static void assert_same_rows(neph_image *whole, neph_image *part, unsigned first) {
  for (unsigned c = 0; c < neph_image_get_channel_count(whole); c++) {
    const char *name = neph_image_get_channel_name(whole, c);
    const size_t width = neph_image_get_width(whole);
    assert_memory_equal(neph_image_get_channel(whole, name) + first * width, neph_image_get_channel(part, name),
                        width * neph_image_get_height(part) * sizeof(float));
  }
}

/* A picture of three bands of rows, and its tiles, whose edges are none of the bands': each pixel has the same samples.
 */
static void tiles_and_threads_change_no_bit(void **state) {
  test_fixture *f = *state;
  neph_context *alone = test_context_create(1, NULL);
  neph_scene *scene = load(f->context, SCENE("12", "150", "march", "0.02")),
             *other = load(alone, SCENE("12", "150", "march", "0.02"));
  neph_image *whole = render(scene, &(order){.target = 0.03, .seed = 5}),
             *again = render(other, &(order){.target = 0.03, .seed = 5});
  assert_same_rows(whole, again, 0);
  char *paths[3];
  for (unsigned i = 0; i < 3; i++) {
    static const char *const names[] = {"0.npart", "1.npart", "2.npart"};
    paths[i] = test_path(f->folder, names[i]);
    neph_image *tile = render(scene, &(order){.target = 0.03, .seed = 5, .tile = i, .tile_count = 3, .part = paths[i]});
    assert_same_rows(whole, tile, 50 * i);
    neph_image_destroy(tile);
  }
  neph_image *merged = NULL;
  neph_pixel_type type;
  assert_int_equal(neph_parts_merge(f->context, (const char *const *)paths, 3, &type, &merged), NEPH_OK);
  assert_same_rows(whole, merged, 0);
  for (unsigned i = 0; i < 3; i++) free(paths[i]);
  neph_image_destroy(merged);
  neph_image_destroy(whole);
  neph_image_destroy(again);
  neph_scene_destroy(scene);
  neph_scene_destroy(other);
  neph_context_destroy(alone);
}

/* Most of the clear sky, all but that beside clouds, takes one sample, a cloud's edge many; the header's mean is
 * theirs. */
static void samples_go_where_noise_is(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f->context, SCENE_OF(BALL, "64", "48", "march", "0.02"));
  neph_image *image = render(scene, &(order){.target = 0.01, .seed = 1});
  const float *counts = neph_image_get_channel(image, "sample_count"), *alpha = neph_image_get_channel(image, "A");
  double least = HUGE_VAL, most = 0.0, sum = 0.0, clear = 0.0, alone = 0.0;
  for (size_t i = 0; i < 64 * 48; i++) {
    least = fmin(least, (double)counts[i]);
    most = fmax(most, (double)counts[i]);
    sum += (double)counts[i];
    if (alpha[i] > 0.0f) continue;
    clear += 1.0;
    alone += counts[i] < 1.5f;
  }
  assert_near(least, 1.0, 0.0);
  assert_true(most >= 16.0 && clear > 100.0 && alone > 0.5 * clear);
  assert_near_relative(sum / (64.0 * 48.0), get_number(image, "nephos:samples"), 1e-5);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

#define ADAPTIVE_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(spread_of_single_samples_is_what_no_plane_explains),
      cmocka_unit_test(spread_of_pilots_is_that_about_their_means),
      cmocka_unit_test(numbers_follow_the_spread),
      ADAPTIVE_TEST(noise_is_the_one_asked_for),
      ADAPTIVE_TEST(many_pictures_have_no_bias),
      ADAPTIVE_TEST(tiles_and_threads_change_no_bit),
      ADAPTIVE_TEST(samples_go_where_noise_is),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
