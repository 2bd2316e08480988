/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds that cannot be meant draw a warning: out of the picture, below the ground, before the near plane, under 10 m
 * or over 1000 km across. */
#include <nephos/nephos.h>

#include "test_box_files.h"

/* 16 m along each axis from sample to sample. */
static const test_box block = {{8, 8, 8}, {25, 25, 25}, 1.0f};

static int set_up(void **state) {
  const int failed = test_set_up(state, 2, "block.vdb");
  const test_fixture *f = *state;
  if (!failed) test_boxes_write(f->context, f->path, "density", &block, 1);
  return failed;
}

static void render_text(test_fixture *f, const char *text) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_load_text(f->context, text, "block.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* A camera that looks north along the ground, 45 degrees to either side and 29 up and down. */
static void render(test_fixture *f, const char *cloud) {
  char text[2048];
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0 m, -100 m, 2 m], look_at: [0 m, 0 m, 2 m], fov: 90 deg, resolution: [64, 36]}\n"
                 "atmosphere: none\n"
                 "render: {samples: 1, multiple_scattering: none}\n"
                 "clouds: [{name: block, %s}]\n",
                 cloud);
  render_text(f, text);
}

static void render_block(test_fixture *f, const char *keys) {
  char cloud[1024];
  (void)snprintf(cloud, sizeof cloud, "vdb: \"%s\", extinction: 0.01 1/m, %s", f->path, keys);
  render(f, cloud);
}

static void render_near(test_fixture *f, const char *near) {
  char text[2048];
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0 m, -100 m, 2 m], look_at: [0 m, 0 m, 2 m], fov: 90 deg, resolution: [64, 36], "
                 "near: %s}\natmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
                 "clouds: [{name: block, vdb: \"%s\", extinction: 0.01 1/m, position: [0, 0, 0]}]\n",
                 near, f->path);
  render_text(f, text);
}

static void assert_said(const test_fixture *f, const char *text) {
  if (!strstr(f->log.text, text)) fail_msg("\"%s\" is not in the log:\n%s", text, f->log.text);
  if (f->log.counts[NEPH_LOG_WARNING] != 1) fail_msg("the log has not one warning:\n%s", f->log.text);
}

static void assert_silent(const test_fixture *f) {
  if (f->log.counts[NEPH_LOG_WARNING]) fail_msg("the log has a warning:\n%s", f->log.text);
}

static void a_cloud_out_of_the_picture_is_named(void **state) {
  test_fixture *f = *state;
  render_block(f, "position: [0, 100 m, 0]");
  assert_silent(f);
  static const char *const places[] = {"[-250 m, 100 m, 0]", "[250 m, 100 m, 0]", "[0, 100 m, 150 m]",
                                       "[0, -200 m, 0]"};
  for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
    char keys[128];
    (void)snprintf(keys, sizeof keys, "position: %s", places[i]);
    render_block(f, keys);
    assert_said(f, "cloud block: lies wholly outside the view, from (");
  }
  assert_said(f, "from (-0.008, -0.208, 0) to (0.008, -0.192, 0.016) km: check clouds[].position, voxel and up, and "
                 "camera.look_at");
}

/* A corner in the picture is enough, and so is a camera inside. */
static void what_reaches_into_the_picture_is_not(void **state) {
  test_fixture *f = *state;
  render_block(f, "position: [-205 m, 100 m, 0]");
  assert_silent(f);
  render_block(f, "position: [0, -100 m, -6 m]");
  assert_silent(f);
}

static void a_cloud_of_no_size_of_clouds_is_named(void **state) {
  test_fixture *f = *state;
  render_block(f, "position: [0, 0, 0], voxel: 0.5 m");
  assert_said(f, "cloud block: is 8 m across, less than 10 m: check clouds[].voxel and scale");
  render_block(f, "position: [0, 0, 0], voxel: 0.7 m");
  assert_silent(f);
  render_block(f, "position: [0, 0, 0], voxel: 100 km");
  assert_said(f, "cloud block: is 1600 km across, more than 1000 km: check clouds[].voxel and scale");
  render_block(f, "position: [0, 0, 0], voxel: 60 km");
  assert_silent(f);
}

/* The camera is at 2 m, and sees 29 degrees below it. */
static void a_cloud_below_the_ground_is_named(void **state) {
  test_fixture *f = *state;
  render_block(f, "position: [0, 0, -20 m]");
  assert_said(f,
              "cloud block: lies wholly below the ground, its top 4 m or more: check clouds[].position, voxel and up");
  render_block(f, "position: [0, 0, -15 m]");
  assert_silent(f);
}

/* It ends 108 m before the camera. */
static void a_cloud_before_the_near_plane_is_named(void **state) {
  test_fixture *f = *state;
  render_near(f, "200 m");
  assert_said(f, "cloud block: ends 108 m before the camera, whose near plane, 200 m away, cuts it off");
  render_near(f, "100 m");
  assert_silent(f);
}

/* Sixteen metres in a picture whose pixels are 12.5 m wide 400 m away, and 31 m a kilometre away. */
static void a_cloud_below_a_pixel_is_named(void **state) {
  test_fixture *f = *state;
  render_block(f, "position: [0, 300 m, 0]");
  assert_silent(f);
  render_block(f, "position: [0, 900 m, 0]");
  assert_said(f,
              "cloud block: subtends 0.52 of a pixel, 1.008 km before the camera: check clouds[].position, voxel and "
              "scale, and camera.fov");
}

/* Hills of two kilometres, and a cloud two thousand to the north. */
static void a_cloud_far_from_the_terrain_is_named(void **state) {
  test_fixture *f = *state;
  char text[2048];
  const char *const places[] = {"[0, 20 km, 0]", "[0, 2000 km, 0]"};
  for (int n = 0; n < 2; n++) {
    (void)snprintf(
        text, sizeof text,
        "camera: {position: [0 m, -100 m, 2 km], look_at: [0 m, 0 m, 2 km], fov: 1 deg, resolution: [64, 36]}\n"
        "atmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
        "terrain: {ridges: {samples: 17, relief: 10 m}, width: 2 km}\n"
        "clouds: [{name: block, vdb: \"%s\", extinction: 0.01 1/m, voxel: 40 m, position: %s, "
        "pivot: center}]\n",
        f->path, places[n]);
    render_text(f, text);
    const bool is_said = strstr(f->log.text, " km from the terrain, which is ") != NULL;
    if (is_said != (n == 1)) fail_msg("%s", f->log.text);
  }
}

static void a_bake_is_told_of_its_own_keys(void **state) {
  test_fixture *f = *state;
  render(f, "bake: {extent: 800 m, voxel: 20 m, thickness: 100 m, base: 1 km, coverage: 0.9}");
  assert_said(f, "check clouds[].bake.center and bake.base, and camera.look_at");
  render(f, "bake: {extent: 200 m, voxel: 20 m, thickness: 100 m, base: 1 km, coverage: 0}");
  assert_said(f, "cloud block: nothing of it was baked in frame 1: its coverage is 0");
}

/* The file that artists try first: units of its own, and y up. */
static void the_cloud_of_another_unit_is_named(void **state) {
  test_fixture *f = *state;
  char *path = test_data_path("vdb/wdas_cloud_sixteenth.vdb"), text[2048];
  (void)snprintf(text, sizeof text,
                 "camera: {resolution: [16, 9]}\nrender: {samples: 1}\n"
                 "clouds: [{name: hero, vdb: \"%s\", up: y, optical_depth: 40}]\n",
                 path);
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(f->context, text, "hero.yaml", &scene), NEPH_OK);
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  assert_said(f, "cloud hero: lies wholly outside the view, from (-0.22, -0.21, -0.07) to (0.197, 0.3, 0.213) km");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  free(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_cloud_out_of_the_picture_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(what_reaches_into_the_picture_is_not, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_of_no_size_of_clouds_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_below_the_ground_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_before_the_near_plane_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_below_a_pixel_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_far_from_the_terrain_is_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_bake_is_told_of_its_own_keys, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_cloud_of_another_unit_is_named, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
