/* SPDX-License-Identifier: Apache-2.0 */
/* Air in front of thin cloud, which is seen once: a wall of cloud 30 km away in the bright air of noon.
 *
 * test_air_before_cloud        the march against what 24,000 paths a pixel have found
 * test_air_before_cloud long   24,000 paths a pixel again: four minutes
 */
#include <math.h>

#include <nephos/nephos.h>

#include "test_contexts.h"

enum { WIDTH = 80, DEPTH = 16, HEIGHT = 60, SAMPLES_LONG = 24000, SAMPLES = 500 };

static const double voxel_m = 25.0, thickness_m = 400.0;

/* A wall across the view, of an even depth along rays through its middle. */
static neph_volume *create_wall(neph_context *context) {
  static float values[WIDTH * DEPTH * HEIGHT];
  for (int i = 0; i < WIDTH * DEPTH * HEIGHT; i++) values[i] = 1.0f;
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.size[0] = WIDTH;
  desc.size[1] = DEPTH;
  desc.size[2] = HEIGHT;
  desc.values = values;
  for (int i = 0; i < 3; i++) desc.index_to_world[i][i] = voxel_m;
  desc.index_to_world[0][3] = -0.5 * voxel_m * (WIDTH - 1);
  desc.index_to_world[1][3] = 30e3;
  desc.index_to_world[2][3] = 3900.0;
  neph_volume *volume = NULL;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  return volume;
}

static const char text[] = "camera: {position: [0 m, 0 m, 1 km], look_at: [0 m, 30 km, 4500 m], fov: 0.6 deg,\n  "
                           "resolution: [6, 4]}\n"
                           "sun: {elevation: 55 deg, azimuth: 240 deg}\n"
                           "output: {pixel_type: float, color_space: bands}\n";

/* Means of the bands, and their standard errors by the spread of the pixels. */
typedef struct picture {
  double mean[3], error[3];
} picture;

static picture render(neph_context *context, const char *integrator, unsigned samples, double depth,
                      const neph_placement_desc *placement) {
  static const char *const names[3] = {"R", "G", "B"};
  char count[16];
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_volume *wall = create_wall(context);
  neph_placement_desc desc = *placement;
  desc.density_value = depth / thickness_m;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_true(snprintf(count, sizeof count, "%u", samples) < (int)sizeof count);
  assert_int_equal(neph_scene_set(scene, "render.samples", count), NEPH_OK);
  assert_int_equal(neph_scene_add_volume(scene, wall, &desc, NULL), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  picture out = {0};
  const unsigned pixels = neph_image_get_width(image) * neph_image_get_height(image);
  for (int b = 0; b < 3; b++)
    for (unsigned i = 0; i < pixels; i++) out.mean[b] += (double)neph_image_get_channel(image, names[b])[i] / pixels;
  for (int b = 0; b < 3; b++) {
    double square = 0.0;
    for (unsigned i = 0; i < pixels; i++)
      square += pow((double)neph_image_get_channel(image, names[b])[i] - out.mean[b], 2.0) / pixels;
    out.error[b] = sqrt(square / (pixels - 1));
  }
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_volume_release(wall);
  return out;
}

/* Cloud that scatters nearly straight on, far from the sun, is nearly invisible: paths say by how much. */
static const double depths[] = {0.3, 1.4, 4.0};
enum { DEPTHS = sizeof depths / sizeof *depths };

static const neph_placement_desc *get_forward(void) {
  static neph_placement_desc forward = NEPH_PLACEMENT_DESC_DEFAULT;
  forward.phase = NEPH_PHASE_HENYEY_GREENSTEIN;
  forward.asymmetry = 0.998;
  forward.albedo[0] = forward.albedo[1] = forward.albedo[2] = 1.0;
  return &forward;
}

/* Means of 24,000 paths a pixel in R, G and B, of standard errors of 0.15 to 0.35 %. */
static const double traced[DEPTHS][3] = {
    {0.043014, 0.10417, 0.19003}, {0.043761, 0.10496, 0.19062}, {0.045064, 0.10588, 0.19027}};

/* The march's own errors of cloud and sky are below 1 % here; the air of 30 km before the cloud, counted twice where
 * the cloud is half opaque, adds a fifth. */
static void air_before_veils_is_seen_once(void **state) {
  test_fixture *f = *state;
  for (int d = 0; d < DEPTHS; d++) {
    const picture march = render(f->context, "march", 16, depths[d], get_forward());
    for (int b = 0; b < 3; b++) assert_near_relative(march.mean[b], traced[d][b], 0.01);
  }
}

/* Within four standard errors, of both. */
static void check_paths(test_fixture *f, unsigned samples) {
  for (int d = 0; d < DEPTHS; d++) {
    const picture path = render(f->context, "path", samples, depths[d], get_forward());
    for (int b = 0; b < 3; b++) {
      print_message("depth %g, band %d: %.5g, standard error %.2g, expected %.5g\n", depths[d], b, path.mean[b],
                    path.error[b], traced[d][b]);
      const double error = hypot(path.error[b], path.error[b] * sqrt((double)samples / SAMPLES_LONG));
      assert_near(path.mean[b], traced[d][b], 4.0 * error);
      assert_true(path.error[b] < 0.0035 * sqrt((double)SAMPLES_LONG / samples) * 1.5 * traced[d][b]);
    }
  }
}

static void paths_still_find_that_light(void **state) { check_paths(*state, SAMPLES); }

static void many_paths_still_find_that_light(void **state) { check_paths(*state, SAMPLES_LONG); }

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(air_before_veils_is_seen_once, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(paths_still_find_that_light, set_up, test_tear_down),
  };
  const struct CMUnitTest long_tests[] = {
      cmocka_unit_test_setup_teardown(many_paths_still_find_that_light, set_up, test_tear_down),
  };
  const bool is_long = argc > 1 && strcmp(argv[1], "long") == 0;
  return is_long ? cmocka_run_group_tests(long_tests, NULL, NULL) : cmocka_run_group_tests(tests, NULL, NULL);
}
