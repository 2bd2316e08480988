/* SPDX-License-Identifier: Apache-2.0 */
/* Motion blur: an opaque block that moves, or that the camera passes, is its picture convolved with a box; light moves
 * with its cloud; bits do not depend on threads and on what was rendered before; what does not move costs nothing. */
#include <nephos/nephos.h>

#include "scene/scene_pose.h"
#include "test_velocity_files.h"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

static const char *const integrators[] = {"march", "path"};

static neph_scene *load(test_fixture *f, const char *text) {
  neph_scene *scene = NULL;
  char *path = test_path(f->folder, "scene.yaml");
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  free(path);
  return scene;
}

static neph_image *render_frame(neph_scene *scene, int frame) {
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.frame = frame;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  return image;
}

static neph_image *render_text(test_fixture *f, const char *text, int frame) {
  neph_scene *scene = load(f, text);
  neph_image *image = render_frame(scene, frame);
  neph_scene_destroy(scene);
  return image;
}

static void write_block(test_fixture *f, const test_velocity *v) {
  char *path = test_path(f->folder, "block.vdb");
  test_velocity_write(f->context, path, v);
  free(path);
}

/* ---- A block and a box ---- */

enum { WIDTH = 32, HEIGHT = 6 };

/* A pixel is a metre. The block's matter ends where its outermost samples have faded to nothing, one voxel beyond them.
 */
static const double half_m = 7.0;
static const test_velocity block = {.names = {"vel"}, .half = 6, .value = 1.0f, .at = {8.0f, 0.0f, 0.0f}};

static neph_image *render_block(test_fixture *f, const char *integrator, const char *shutter, const char *keys,
                                const char *camera_keys) {
  char text[1600];
  (void)snprintf(text, sizeof text,
                 "frame_rate: 1\n"
                 "camera: {kind: orthographic, orthographic_width: 32 m, position: [0, -50 m, 0], look_at: [0, 0, 0],\n"
                 "  resolution: [%d, %d], motion_blur: {%s}}\n"
                 "environment: {planet: none}\n"
                 "clouds: [{vdb: block.vdb, extinction: 50 1/m%s}]\n"
                 "%s\n"
                 "render: {samples: 256, integrator: %s}\n"
                 "output: {beauty: false, aovs: [transmittance], pixel_type: float}\n",
                 WIDTH, HEIGHT, shutter, keys, camera_keys, integrator);
  return render_text(f, text, 1);
}

/* Opacity at x of a block whose middle passes from `begin` to `end`, seen through a tent of a pixel to each side. */
static double eval_block(double x, double begin, double end) {
  enum { STEPS = 400 };
  double sum = 0.0, weights = 0.0;
  for (int k = 0; k < STEPS; k++) {
    const double aside = 2.0 * (k + 0.5) / STEPS - 1.0, at = x + aside, weight = 1.0 - fabs(aside);
    const double from = fmax(begin, at - half_m), to = fmin(end, at + half_m);
    sum += weight * fmax(to - from, 0.0) / (end - begin);
    weights += weight;
  }
  return sum / weights;
}

/* 256 samples that are even in three dimensions miss a step by about 256^(−2/3), and six rows by as much over √6. */
static void assert_block(neph_image *image, double begin, double end) {
  const float *transmittance = neph_image_get_channel(image, "transmittance");
  for (int x = 0; x < WIDTH; x++) {
    double mean = 0.0;
    for (int y = 0; y < HEIGHT; y++) mean += (1.0 - (double)transmittance[y * WIDTH + x]) / HEIGHT;
    assert_near(mean, eval_block(x + 0.5 - 0.5 * WIDTH, begin, end), 0.01);
  }
  neph_image_destroy(image);
}

static void a_block_with_velocities(void **state) {
  test_fixture *f = *state;
  write_block(f, &block);
  for (int i = 0; i < 2; i++) {
    assert_block(render_block(f, integrators[i], "shutter: 0.5", "", ""), -2.0, 2.0);
    assert_block(render_block(f, integrators[i], "shutter: 0.25, offset: 0.125", ", velocity_scale: -2", ""), -4.0,
                 0.0);
  }
  assert_block(render_block(f, "march", "shutter: 0.01", ", velocity: none", ""), -1e-3, 1e-3);
}

/* The box of its active samples stands on −6 m. */
static void a_block_with_tracks(void **state) {
  test_fixture *f = *state;
  test_velocity still = block;
  still.names[0] = NULL;
  write_block(f, &still);
  static const char tracks[] = "animate:\n  clouds[0].position.0: [[0, -8 m], [2, 8 m]]";
  for (int i = 0; i < 2; i++) {
    assert_block(render_block(f, integrators[i], "shutter: 0.5", ", position: [0, 0, -6 m]", tracks), -2.0, 2.0);
    assert_block(render_block(f, integrators[i], "shutter: 0.5, offset: 0.25", ", position: [0, 0, -6 m]", tracks), 0.0,
                 4.0);
  }
}

/* Velocities and tracks add up. */
static void both_together(void **state) {
  test_fixture *f = *state;
  write_block(f, &block);
  static const char tracks[] = "animate:\n  clouds[0].position.0: [[0, -4 m], [2, 4 m]]";
  assert_block(render_block(f, "march", "shutter: 0.5", ", position: [0, 0, -6 m]", tracks), -3.0, 3.0);
}

static void a_camera_that_moves(void **state) {
  test_fixture *f = *state;
  test_velocity still = block;
  still.names[0] = NULL;
  write_block(f, &still);
  static const char tracks[] =
      "animate: {camera.position.0: [[0, 8 m], [2, -8 m]], camera.look_at.0: [[0, 8 m], [2, -8 m]]}";
  for (int i = 0; i < 2; i++) assert_block(render_block(f, integrators[i], "shutter: 0.5", "", tracks), -2.0, 2.0);
}

/* The middle of the picture runs along a smooth track: at the mean of the places in the exposure. */
static void a_track_is_followed_within_the_exposure(void **state) {
  test_fixture *f = *state;
  test_velocity still = block;
  still.names[0] = NULL;
  write_block(f, &still);
  static const char tracks[] =
      "animate:\n  clouds[0].position.0: {interpolation: smooth, keys: [[0, 0 m], [1, 8 m], [2, 0 m]]}";
  neph_image *image = render_block(f, "march", "shutter: 1", ", position: [0, 0, -6 m]", tracks);
  const float *transmittance = neph_image_get_channel(image, "transmittance");
  double sum = 0.0, moment = 0.0, expected = 0.0;
  for (int p = 0; p < WIDTH * HEIGHT; p++) {
    sum += 1.0 - (double)transmittance[p];
    moment += (1.0 - (double)transmittance[p]) * (p % WIDTH + 0.5 - 0.5 * WIDTH);
  }
  for (int k = 0; k < 1000; k++) { /* tangents are 0 at all three keys: 3s² − 2s³ */
    const double s = 1.0 - fabs(((double)k + 0.5) / 1000.0 - 0.5);
    expected += 8.0 * s * s * (3.0 - 2.0 * s) / 1000.0;
  }
  assert_near(moment / sum, expected, 0.02);
  neph_image_destroy(image);
}

/* ---- Light ---- */

/* A soft ball in the sun, 4 m from where its light was solved for at the ends: against pictures of its places. */
static void light_moves_with_its_cloud(void **state) {
  test_fixture *f = *state;
  enum { STILLS = 8 };
  const test_velocity ball = {.radius = 8.0, .value = 1.0f};
  write_block(f, &ball);
  static const char format[] =
      "camera: {kind: orthographic, orthographic_width: 32 m, position: [0, -50 m, 0], look_at: [0, 0, 0],\n"
      "  resolution: [16, 8]%s}\n"
      "environment: {planet: none}\n"
      "sun: {elevation: 30 deg, azimuth: 100 deg}\n"
      "clouds: [{vdb: block.vdb, extinction: 1 1/m, position: [%g m, 0, -7 m]}]\n"
      "%s\n"
      "render: {samples: %d, tolerance: 0.01}\n"
      "output: {pixel_type: float}\n";
  char text[1200];
  double expected = 0.0, expected_moment = 0.0, sum = 0.0, moment = 0.0;
  for (int k = 0; k <= STILLS; k++) {
    const bool is_still = k < STILLS;
    (void)snprintf(text, sizeof text, format, is_still ? "" : ", motion_blur: {shutter: 0.5}",
                   is_still ? 8.0 * (k + 0.5) / STILLS - 4.0 : 0.0,
                   is_still ? "" : "animate:\n  clouds[0].position.0: [[0, -16 m], [2, 16 m]]", is_still ? 8 : 64);
    neph_image *image = render_text(f, text, 1);
    const float *g = neph_image_get_channel(image, "G");
    for (int p = 0; p < 16 * 8; p++) {
      *(is_still ? &expected : &sum) += (double)g[p] / (is_still ? STILLS : 1);
      *(is_still ? &expected_moment : &moment) += (double)g[p] * (p % 16 - 7.5) / (is_still ? STILLS : 1);
    }
    neph_image_destroy(image);
  }
  assert_near_relative(sum, expected, 0.01); /* cells of light lie otherwise in each still */
  assert_near(moment / sum, expected_moment / expected, 0.05);
}

/* ---- Promises ---- */

static const char moving[] =
    "frame_rate: 1\n"
    "camera: {position: [0, -50 m, 0], look_at: [0, 0, 0], fov: 40 deg, resolution: [16, 12], motion_blur: {}}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
    "clouds: [{vdb: block.vdb, extinction: 0.1 1/m, position: [0, 0, 6 m]}]\n"
    "animate:\n"
    "  camera.position.0: [[1, 0 m], [3, 20 m]]\n"
    "  clouds[0].position.2: [[1, 6 m], [3, 12 m]]\n"
    "render: {samples: 3}\n"
    "output: {pixel_type: float, image: a.##.exr, aovs: [motion]}\n";

static void assert_same(neph_image *a, neph_image *b) {
  static const char *const names[] = {"R", "G", "B", "A", "Z"};
  for (size_t n = 0; n < sizeof names / sizeof *names; n++)
    assert_memory_equal(neph_image_get_channel(a, names[n]), neph_image_get_channel(b, names[n]),
                        16 * 12 * sizeof(float));
}

static void a_frame_alone_is_that_of_the_sequence(void **state) {
  test_fixture *f = *state;
  write_block(f, &block);
  test_log log;
  test_log_start(&log);
  test_fixture single = *f;
  single.context = test_context_create(1, &log);
  neph_image *alone = render_text(&single, moving, 2);
  neph_scene *scene = load(f, moving);
  neph_image_destroy(render_frame(scene, 1));
  neph_image *next = render_frame(scene, 2);
  assert_same(alone, next);
  neph_image_destroy(next);
  neph_image_destroy(alone);
  neph_scene_destroy(scene);
  neph_context_destroy(single.context);
}

/* Nothing moves, or jumps alone: the picture is that without motion blur, to the bit. */
static void what_stays_is_as_without(void **state) {
  test_fixture *f = *state;
  test_velocity still = block;
  still.names[0] = NULL;
  write_block(f, &still);
  static const char *const keys[][2] = {
      {"camera.motion_blur", "none"},
      {"camera.motion_blur", "{shutter: 0.5}"},
      {"animate", "{camera.fov: {interpolation: step, keys: [[1, 20 deg], [2, 40 deg]]}}"}};
  neph_image *images[3];
  neph_scene *scene = load(f, moving);
  assert_int_equal(neph_scene_set(scene, "animate", "{camera.fov: [[1, 40 deg]]}"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[]"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "clouds[0].velocity", "none"), NEPH_OK);
  for (int i = 0; i < 3; i++) {
    assert_int_equal(neph_scene_set(scene, keys[i][0], keys[i][1]), NEPH_OK);
    images[i] = render_frame(scene, 2);
  }
  assert_same(images[0], images[1]);
  assert_same(images[0], images[2]);
  for (int i = 0; i < 3; i++) neph_image_destroy(images[i]);
  neph_scene_destroy(scene);
}

static void exposures(void **state) {
  test_fixture *f = *state;
  static const struct {
    const char *keys;
    double open, close;
  } rows[] = {{"motion_blur: {}", -0.25, 0.25},
              {"shutter: 0.005 s, motion_blur: {}", -0.06, 0.06}, /* 24 frames a second */
              {"motion_blur: {shutter: 0.25, offset: 0.125}", 0.0, 0.25},
              {"motion_blur: none", 0.0, 0.0},
              {"fov: 40 deg", 0.0, 0.0}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char text[200];
    double open, close;
    (void)snprintf(text, sizeof text, "frame_rate: 24\ncamera: {%s}\n", rows[i].keys);
    neph_scene *scene = load(f, text);
    np_scene_get_exposure(scene, &open, &close);
    assert_near(open, rows[i].open, 1e-12);
    assert_near(close, rows[i].close, 1e-12);
    neph_scene_destroy(scene);
  }
}

static void deep_pixels_are_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, moving);
  neph_image *image;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_set(scene, "output.deep", "deep.exr"), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_BAD_SCENE);
  assert_non_null(strstr(f->log.text, "camera.motion_blur goes without output.deep"));
  neph_scene_destroy(scene);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_block_with_velocities),
      TEST(a_block_with_tracks),
      TEST(both_together),
      TEST(a_camera_that_moves),
      TEST(a_track_is_followed_within_the_exposure),
      TEST(light_moves_with_its_cloud),
      TEST(a_frame_alone_is_that_of_the_sequence),
      TEST(what_stays_is_as_without),
      TEST(exposures),
      TEST(deep_pixels_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
