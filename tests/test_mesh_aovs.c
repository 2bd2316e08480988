/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of geometry over a mesh as ground, in both integrators: a tilted plane, whose depth, normal, places and
 * motion are known in each pixel. */
#include <stdlib.h>

#include <nephos/nephos.h>

#include "test_support.h"

enum { EDGE = 12 };

static const double slope_x = 0.25, slope_y = -0.125, height_m = 400.0, eye_m = 1300.0, step_m = 6.0;

static int set_up(void **state) { return test_set_up_cached(state, 2, "plane.obj"); }

static double get_height(double x, double y) { return height_m + slope_x * x + slope_y * y; }

/* A square of 1600 m around the origin. */
static void write_plane(const char *path) {
  char text[512] = "";
  for (int k = 0; k < 4; k++) {
    const double x = k % 2 ? 800.0 : -800.0, y = k / 2 ? 800.0 : -800.0;
    (void)snprintf(text + strlen(text), sizeof text - strlen(text), "v %.1f %.1f %.3f\n", x, y, get_height(x, y));
  }
  (void)strcat(text, "f 1 2 4\nf 1 4 3\n");
  test_file_write_text(path, text);
}

/* Straight down from 1300 m, the camera on its way east by 6 m a frame. */
static neph_image *render(test_fixture *f, const char *integrator) {
  char text[1024], *path = test_path(f->folder, "scene.yaml");
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [0 m, 0 m, %g m], look_at: [0 m, 0 m, 0 m], fov: 40 deg, resolution: [%d, %d]}\n"
                 "atmosphere: {preset: none}\n"
                 "terrain: {mesh: {file: plane.obj, up: z, normals: flat}}\n"
                 "animate:\n"
                 "  camera.position: [[0, [%g m, 0 m, %g m]], [2, [%g m, 0 m, %g m]]]\n"
                 "  camera.look_at: [[0, [%g m, 0 m, 0 m]], [2, [%g m, 0 m, 0 m]]]\n"
                 "render: {samples: 1, integrator: %s}\n"
                 "output: {beauty: false, aovs: [depth, normal, position, motion, mattes], pixel_type: float}\n",
                 eye_m, EDGE, EDGE, -step_m, eye_m, step_m, eye_m, -step_m, step_m, integrator);
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  if (neph_scene_load_text(f->context, text, path, &scene)) fail_msg("%s", f->log.text);
  test_log_clear(&f->log);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  neph_scene_destroy(scene);
  free(path);
  return image;
}

static double get(neph_image *image, const char *channel, int p) {
  const float *values = neph_image_get_channel(image, channel);
  if (!values) fail_msg("no channel %s", channel);
  return (double)values[p];
}

/* Depth of the plane along the view through the centre of a pixel; its corner shows the direction of the axes. */
static double compute_depth(neph_image *image, int p, double focal) {
  const double right = get(image, "position.X", 0) < get(image, "position.X", EDGE - 1) ? 1.0 : -1.0;
  const double down = get(image, "position.Y", 0) < get(image, "position.Y", EDGE * (EDGE - 1)) ? 1.0 : -1.0;
  const double x = right * (p % EDGE + 0.5 - 0.5 * EDGE) / focal, y = down * (p / EDGE + 0.5 - 0.5 * EDGE) / focal;
  return (eye_m - height_m) / (1.0 + slope_x * x + slope_y * y);
}

/* Places are floats of some 1000 m, and on the plane, somewhere in their pixel; Z is that of its middle. */
static void channels_are_those_of_the_plane(void **state) {
  static const char *const integrators[] = {"march", "path"};
  test_fixture *f = *state;
  if (!neph_feature_is_present(f->context, NEPH_FEATURE_ASSIMP)) skip();
  write_plane(f->path);
  const double length = sqrt(1.0 + slope_x * slope_x + slope_y * slope_y);
  const double focal = EDGE / (2.0 * tan(20.0 * acos(-1.0) / 180.0)); /* pixels at a distance of 1 */
  for (int i = 0; i < 2; i++) {
    neph_image *image = render(f, integrators[i]);
    for (int p = 0; p < EDGE * EDGE; p++) {
      const double x = get(image, "position.X", p), y = get(image, "position.Y", p), depth = eye_m - get_height(x, y);
      assert_near(get(image, "position.Z", p), get_height(x, y), 2e-3);
      assert_near(get(image, "Z", p), compute_depth(image, p, focal), 2e-3);
      assert_near(get(image, "normal.X", p), -slope_x / length, 1e-5);
      assert_near(get(image, "normal.Y", p), -slope_y / length, 1e-5);
      assert_near(get(image, "normal.Z", p), 1.0 / length, 1e-5);
      assert_near(get(image, "matte.ground", p), 1.0, 1e-6);
      /* The camera moves east, so the ground moves west. */
      assert_near(fabs(get(image, "forward.u", p)), focal * step_m / depth, 1e-3);
      assert_near(get(image, "forward.u", p), -get(image, "backward.u", p), 1e-3);
      assert_near(get(image, "forward.v", p), 0.0, 1e-3);
    }
    neph_image_destroy(image);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(channels_are_those_of_the_plane, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
