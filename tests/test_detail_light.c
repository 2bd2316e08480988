/* SPDX-License-Identifier: Apache-2.0 */
/* Light in clouds whose detail is finer than their voxels, against what paths find in the same detail. */
#include <math.h>

#include <nephos/nephos.h>

#include "test_contexts.h"

/* Small cumuli of voxels so large that detail is most of what they are, under a high sun, over dark ground. */
static const char text[] =
    "camera: {position: [-1800 m, -1800 m, 900 m], look_at: [0 m, 0 m, 1350 m], fov: 50 deg, resolution: [32, 18]}\n"
    "sun: {elevation: 80 deg, azimuth: 60 deg}\n"
    "atmosphere: {ground_albedo: 0.03}\n"
    "clouds: [{bake: {preset: cumulus_humilis, seed: 906557, extent: 3 km, voxel: 71.2 m, base: 1186 m},\n"
    "  detail: {strength: 0.8, size: 142.4 m}}]\n"
    "output: {pixel_type: float}\n";

static neph_image *render(neph_context *context, const char *integrator, const char *samples, const char *seed) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", samples), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.seed", seed), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Mean of the red of the pixels that are cloud in another picture. */
static double average_cloud(const neph_image *image, const neph_image *cloud) {
  const float *red = neph_image_get_values(image, "R"), *opacity = neph_image_get_values(cloud, "A");
  const unsigned pixels = neph_image_get_width(image) * neph_image_get_height(image);
  const unsigned above = pixels * 3 / 4; /* rows above the ground */
  double sum = 0.0, count = 0.0;
  for (unsigned i = 0; i < above; i++) {
    if (!(opacity[i] > 0.5f)) continue;
    sum += (double)red[i];
    count++;
  }
  assert_true(count > 30.0);
  return sum / count;
}

enum { SEEDS = 4 };

/* Cells of one voxel that took its detail from a single point, and sunlight that met none of it, lost 4.3 % of this
 * light. Three leave room for the noise of the paths, 0.6 %, and for the cells' own 2 %. */
static void light_meets_the_detail_that_is_seen(void **state) {
  (void)state;
  static const char *const seeds[SEEDS] = {"1", "2", "3", "4"};
  neph_context *context = test_context_create_cached(2, NULL);
  neph_image *march = render(context, "march", "64", "0");
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < SEEDS; k++) {
    neph_image *paths = render(context, "path", "100", seeds[k]);
    const double mean = average_cloud(paths, march);
    sum += mean / SEEDS;
    squares += mean * mean / SEEDS;
    neph_image_destroy(paths);
  }
  const double error = sqrt(fmax(squares - sum * sum, 0.0) / (SEEDS - 1)), marched = average_cloud(march, march);
  print_message("march %+.2f %% of paths, whose noise is %.2f %%\n", 100.0 * (marched / sum - 1.0),
                100.0 * error / sum);
  assert_true(error < 0.012 * sum);
  assert_near_relative(marched, sum, 0.03);
  neph_image_destroy(march);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(light_meets_the_detail_that_is_seen)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
