/* SPDX-License-Identifier: Apache-2.0 */
/* Paths whose rays towards the sun take the cache of its optical depths for a control variate, against paths that trace
 * them all. */
#include <math.h>

#include <nephos/nephos.h>

#include "test_contexts.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT, SEEDS = 4 };

/* Clouds of other kinds, suns and phase functions; the cache errs most where a cloud is thin or coarse. */
static const char *const scenes[] = {
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "clouds: [{bake: {preset: cumulus_mediocris, seed: 71, extent: 3 km, base: 1 km, voxel: 60 m}, phase: {hg: "
    "0.85}}]\n",
    "sun: {elevation: 8 deg, azimuth: 230 deg}\n"
    "clouds: [{bake: {preset: altocumulus_floccus, seed: 5, extent: 4 km, base: 1500 m, voxel: 50 m}, albedo: 0.9}]\n",
    "sun: {elevation: 70 deg, azimuth: 250 deg}\n"
    "clouds: [{bake: {preset: cirrus, seed: 9, extent: 5 km, base: 2 km, voxel: 80 m}, phase: {hg: 0.3}},\n"
    "         {bake: {preset: stratus, seed: 2, extent: 4 km, base: 600 m, voxel: 60 m}, phase: {hg: 0}}]\n",
};

static neph_image *render(unsigned scene_number, const char *method, unsigned samples, uint64_t seed) {
  neph_context *context = test_context_create_cached(2, NULL);
  neph_scene *scene;
  neph_image *image;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(context, scenes[scene_number], "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "camera", "{position: [0 m, -5 km, 900 m], look_at: [0 m, 0 m, 1500 m]}"),
                   NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "camera.resolution", "[24, 16]"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "atmosphere", "none"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "environment", "{radiance: 0.01, planet: none}"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.sun_optical_depth", method), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.integrator = NEPH_INTEGRATOR_PATH;
  desc.sample_count = samples;
  desc.seed = seed;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return image;
}

/* Mean of G over some rows, and its variance over pictures of SEEDS seeds; no value may be negative. */
typedef struct strip {
  double mean, variance;
} strip;

static void measure(unsigned scene, const char *method, unsigned samples, strip out[2]) {
  double sum[2] = {0.0, 0.0}, squares[2] = {0.0, 0.0};
  for (unsigned seed = 0; seed < SEEDS; seed++) {
    neph_image *image = render(scene, method, samples, 1 + seed);
    const float *values = neph_image_get_values(image, "G");
    double mean[2] = {0.0, 0.0};
    for (unsigned i = 0; i < PIXELS; i++) {
      assert_true(values[i] >= 0.0f);
      mean[i / (PIXELS / 2)] += 2.0 * (double)values[i] / PIXELS;
    }
    for (int half = 0; half < 2; half++) sum[half] += mean[half], squares[half] += mean[half] * mean[half];
    neph_image_destroy(image);
  }
  for (int half = 0; half < 2; half++) {
    out[half].mean = sum[half] / SEEDS;
    out[half].variance = (squares[half] / SEEDS - out[half].mean * out[half].mean) / (SEEDS - 1);
  }
}

/* The upper and the lower half of the picture, as dark as they may be: within 5 deviations of Student's distribution of
 * 2·(4 − 1) degrees of freedom, beyond which one of 400 draws is, six draws. */
static void known_depths_bring_no_bias(void **state) {
  (void)state;
  for (unsigned scene = 0; scene < sizeof scenes / sizeof *scenes; scene++) {
    strip known[2], traced[2];
    measure(scene, "volume", 256, known);
    measure(scene, "march", 256, traced);
    for (int half = 0; half < 2; half++) {
      const double deviation = sqrt(known[half].variance + traced[half].variance);
      print_message("scene %u, half %d: %.5f by the cache, %.5f without, %.2f deviations\n", scene, half,
                    known[half].mean, traced[half].mean, (known[half].mean - traced[half].mean) / deviation);
      assert_true(fabs(known[half].mean - traced[half].mean) < 5.0 * deviation);
      assert_true(deviation < 0.02 * traced[half].mean); /* the comparison says something */
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(known_depths_bring_no_bias),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
