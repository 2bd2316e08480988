/* SPDX-License-Identifier: Apache-2.0 */
/* Motion vectors against differences of projected places: of ground, of clouds that stand, move as a whole or by their
 * velocities, and of the sky. */
#include <nephos/nephos.h>

#include "scene/camera.h"
#include "test_velocity_files.h"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

enum { WIDTH = 24, HEIGHT = 18, FRAME = 2 };

static const char *const integrators[] = {"march", "path"};

static const char format[] =
    "frame_rate: 2\n"
    "camera: {position: [0, -50 m, 20 m], look_at: [0, 0, 8 m], fov: 60 deg, resolution: [24, 18]%s}\n"
    "atmosphere: {preset: none}\n"
    "clouds: [{vdb: block.vdb, extinction: 1000 1/m, position: [0, 0, 4 m]%s}]\n"
    "animate:\n"
    "  camera.position: [[1, [-4 m, -52 m, 20 m]], [2, [0, -50 m, 20 m]], [3, [7 m, -49 m, 23 m]]]\n"
    "  camera.roll: [[1, 0 deg], [3, 4 deg]]\n"
    "  camera.fov: [[1, 62 deg], [3, 59 deg]]\n"
    "%s\n"
    "render: {samples: 1, integrator: %s}\n"
    "output: {beauty: false, aovs: [motion, position, transmittance], pixel_type: float}\n";

typedef struct motion_case {
  const char *camera, *cloud, *tracks;
  np_dvec3 forward_m, backward_m; /* the cloud's own, to the next frame and to the previous one */
} motion_case;

static neph_scene *load(test_fixture *f, const motion_case *c, const char *integrator) {
  char text[2000], *path = test_path(f->folder, "scene.yaml");
  neph_scene *scene = NULL;
  (void)snprintf(text, sizeof text, format, c->camera, c->cloud, c->tracks, integrator);
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  free(path);
  return scene;
}

static np_camera get_camera(neph_scene *scene, int frame) {
  np_camera camera;
  assert_int_equal(neph_scene_set_frame(scene, frame), NEPH_OK);
  assert_int_equal(np_camera_init(scene, WIDTH, HEIGHT, NEPH_EYE_CENTRE, &camera), NEPH_OK);
  return camera;
}

static neph_image *render_frame(neph_scene *scene) {
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.frame = FRAME;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  return image;
}

/* Pixels to the right and up from one picture of a place to another one's. */
static void compute_vector(const np_camera *from, const np_camera *to, np_dvec3 now, np_dvec3 then, double out[2]) {
  double a[2], b[2], depth;
  assert_true(np_camera_project(from, now, a, &depth) && np_camera_project(to, then, b, &depth));
  out[0] = b[0] - a[0];
  out[1] = a[1] - b[1];
}

static double get(neph_image *image, const char *channel, int p) {
  return (double)neph_image_get_channel(image, channel)[p];
}

static np_dvec3 get_position(neph_image *image, int p) {
  return np_dvec3_make(get(image, "position.X", p), get(image, "position.Y", p), get(image, "position.Z", p));
}

/* Distance from which places are too coarse in floats. */
static const double far_m = 500.0;

/* Below a pixel of sky or of far ground: the filter may reach the horizon, and the mean of a ray on either side is the
 * place of neither. */
static bool is_at_horizon(neph_image *image, int p) {
  const double above_m = p >= WIDTH ? np_dvec3_length(get_position(image, p - WIDTH)) : 0.0;
  return above_m == 0.0 || above_m > far_m;
}

/* Places are floats of up to some hundred metres: 1e-5 m, of which a pixel is a twentieth and more. Ground near the
 * horizon is kilometres away, and farther below its float. */
static unsigned assert_vectors(neph_image *image, const np_camera cameras[3], const motion_case *c) {
  unsigned counts[2] = {0, 0};
  for (int p = 0; p < WIDTH * HEIGHT; p++) {
    const np_dvec3 at = get_position(image, p);
    const bool is_cloud = get(image, "transmittance", p) < 1e-5; /* so little of the ground is mixed in */
    if (np_dvec3_length(at) == 0.0 || np_dvec3_length(at) > far_m) continue;
    if (!is_cloud && (get(image, "transmittance", p) < 1.0 || is_at_horizon(image, p))) continue;
    const np_dvec3 still = np_dvec3_make(0, 0, 0);
    double forward[2], backward[2];
    compute_vector(&cameras[1], &cameras[2], at, np_dvec3_add(at, is_cloud ? c->forward_m : still), forward);
    compute_vector(&cameras[1], &cameras[0], at, np_dvec3_add(at, is_cloud ? c->backward_m : still), backward);
    assert_near(get(image, "forward.u", p), forward[0], 1e-3);
    assert_near(get(image, "forward.v", p), forward[1], 1e-3);
    assert_near(get(image, "backward.u", p), backward[0], 1e-3);
    assert_near(get(image, "backward.v", p), backward[1], 1e-3);
    counts[is_cloud]++;
  }
  assert_true(counts[0] > 40);
  return counts[1];
}

static void assert_case(test_fixture *f, const motion_case *c) {
  for (int i = 0; i < 2; i++) {
    neph_scene *scene = load(f, c, integrators[i]);
    np_camera cameras[3];
    for (int k = 0; k < 3; k++) cameras[k] = get_camera(scene, FRAME - 1 + k);
    neph_image *image = render_frame(scene);
    assert_true(assert_vectors(image, cameras, c) > 20);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

static void write_block(test_fixture *f, const test_velocity *v) {
  char *path = test_path(f->folder, "block.vdb");
  test_velocity_write(f->context, path, v);
  free(path);
}

static void ground_and_a_cloud_that_stands(void **state) {
  test_fixture *f = *state;
  write_block(f, &(test_velocity){.half = 6, .value = 1.0f});
  assert_case(f, &(motion_case){"", "", "", {0, 0, 0}, {0, 0, 0}});
}

static void a_cloud_that_moves_as_a_whole(void **state) {
  test_fixture *f = *state;
  write_block(f, &(test_velocity){.half = 6, .value = 1.0f});
  assert_case(f, &(motion_case){"",
                                "",
                                "  clouds[0].position: [[1, [-5 m, 2 m, 4 m]], [2, [0, 0, 4 m]], [3, [3 m, 0, 9 m]]]",
                                {3, 0, 5},
                                {-5, 2, 0}});
}

/* Two frames a second; the file's x is rotated to north. */
static void a_cloud_with_velocities(void **state) {
  test_fixture *f = *state;
  write_block(f, &(test_velocity){.names = {"vel"}, .half = 6, .value = 1.0f, .at = {4.0f, 0.0f, 1.0f}});
  assert_case(f, &(motion_case){"", ", velocity_scale: 3, rotation: 90 deg", "", {0, 6, 1.5}, {0, -6, -1.5}});
}

/* Positions under an open shutter are those of the frame's time: a mean over the block, which changes a vector by no
 * more than its width changes from pixel to pixel. */
static void vectors_of_a_blurred_picture(void **state) {
  test_fixture *f = *state;
  write_block(f, &(test_velocity){.names = {"vel"}, .half = 6, .value = 1.0f, .at = {4.0f, 0.0f, 1.0f}});
  const motion_case cases[] = {{.camera = "", .cloud = "", .tracks = ""},
                               {.camera = ", motion_blur: {shutter: 0.5}", .cloud = "", .tracks = ""}};
  double mean[2][4] = {{0}};
  for (int k = 0; k < 2; k++) {
    static const char *const names[] = {"forward.u", "forward.v", "backward.u", "backward.v"};
    neph_scene *scene = load(f, &cases[k], "march");
    assert_int_equal(neph_scene_set(scene, "render.samples", "64"), NEPH_OK);
    neph_image *image = render_frame(scene);
    double weights = 0.0;
    for (int p = 0; p < WIDTH * HEIGHT; p++) {
      const double weight = get(image, "transmittance", p) < 1e-5 ? 1.0 : 0.0;
      for (int n = 0; n < 4; n++) mean[k][n] += weight * get(image, names[n], p);
      weights += weight;
    }
    for (int n = 0; n < 4; n++) mean[k][n] /= weights;
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
  for (int n = 0; n < 4; n++) assert_near(mean[1][n], mean[0][n], 0.15);
}

/* The sky moves by the camera's turning alone: by 4 pixels, and where it does not turn not at all. */
static void the_sky_turns(void **state) {
  test_fixture *f = *state;
  write_block(f, &(test_velocity){.half = 6, .value = 1.0f});
  static const char *const tracks[] = {"{camera.position: [[1, [0, -50 m, 20 m]], [3, [20 m, -50 m, 20 m]]], "
                                       "camera.look_at: [[1, [0, 0, 20 m]], [3, [20 m, 0, 20 m]]]}",
                                       "{camera.roll: [[1, -10 deg], [3, 10 deg]]}"};
  for (int k = 0; k < 2; k++) {
    const motion_case c = {.camera = "", .cloud = "", .tracks = ""};
    neph_scene *scene = load(f, &c, "march");
    assert_int_equal(neph_scene_set(scene, "animate", tracks[k]), NEPH_OK);
    np_camera cameras[3];
    for (int n = 0; n < 3; n++) cameras[n] = get_camera(scene, FRAME - 1 + n);
    neph_image *image = render_frame(scene);
    unsigned count = 0;
    for (int p = 0; p < WIDTH; p++) {
      np_vec3 direction;
      double a[2], b[2];
      if (get(image, "transmittance", p) < 1.0 || get(image, "position.Y", p) != 0.0) continue;
      (void)np_camera_get_direction(&cameras[1], (float)p + 0.5f, 0.5f, &direction);
      assert_true(np_camera_project_direction(&cameras[1], np_vec3_to_double(direction), a));
      assert_true(np_camera_project_direction(&cameras[2], np_vec3_to_double(direction), b));
      /* A sample is up to a pixel away, and the picture turns by 10 deg a frame. */
      assert_near(get(image, "forward.u", p), b[0] - a[0], k ? 0.2 : 1e-4);
      assert_near(get(image, "forward.v", p), a[1] - b[1], k ? 0.2 : 1e-4);
      count++;
    }
    assert_true(count > 20);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(ground_and_a_cloud_that_stands),
      TEST(a_cloud_that_moves_as_a_whole),
      TEST(a_cloud_with_velocities),
      TEST(vectors_of_a_blurred_picture),
      TEST(the_sky_turns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
