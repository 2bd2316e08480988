/* SPDX-License-Identifier: Apache-2.0 */
/* Keys by frame: known values between key frames, and frames that are the same alone and in a sequence. */
#include <limits.h>

#include <nephos/nephos.h>

#include "scene/scene_lights.h"
#include "scene/sequence.h"
#include "scene/track.h"
#include "test_scenes.h"

enum { WIDTH = 24, HEIGHT = 16 };

/* A camera and a sun that move about a cloud of half a second. */
static const char moving[] =
    "{camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 800 m], fov: 40 deg, resolution: [24, 16]},"
    " sun: {elevation: 30 deg, azimuth: 140 deg}, place: {latitude: 40, longitude: 5},"
    " clouds: [{name: a, bake: {preset: cumulus_mediocris, model: hero, seed: 3, extent: [800 m, 800 m], voxel: 50 "
    "m}}],"
    " animate: {camera.position: [[1, [0, -3 km, 400 m]], [11, [400 m, -2.6 km, 700 m]]]},"
    " render: {samples: 1}, output: {pixel_type: float, image: a.##.exr}}";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, moving); }

/* ---- Tracks ---- */

static double eval(np_interpolation interpolation, double frame) {
  double frames[] = {0.0, 10.0, 20.0, 30.0}, values[] = {0.0, 1.0, 5.0, 4.0};
  const np_track track = {
      .value_count = 1, .interpolation = interpolation, .key_count = 4, .frames = frames, .values = values};
  return np_track_eval(&track, 0, frame);
}

static void values_between_key_frames(void **state) {
  (void)state;
  for (int i = 0; i < NP_INTERPOLATION_COUNT; i++) {
    const np_interpolation kind = (np_interpolation)i;
    assert_near(eval(kind, -5.0), 0.0, 0.0);
    assert_near(eval(kind, 0.0), 0.0, 0.0);
    assert_near(eval(kind, 10.0), 1.0, 0.0);
    assert_near(eval(kind, 30.0), 4.0, 0.0);
    assert_near(eval(kind, 99.0), 4.0, 0.0);
  }
  assert_near(eval(NP_INTERPOLATION_STEP, 19.9), 1.0, 0.0);
  assert_near(eval(NP_INTERPOLATION_LINEAR, 12.5), 2.0, 1e-12);
  /* Steffen: tangents 0 at the ends and at the maximum; 0.2 at 10, twice the least slope beside it. */
  assert_near(eval(NP_INTERPOLATION_SMOOTH, 5.0), 0.5 - 0.25, 1e-12);
  assert_near(eval(NP_INTERPOLATION_SMOOTH, 15.0), 3.0 + 0.25, 1e-12);
}

/* Nowhere beyond the keys of its interval, and without a corner. */
static void smooth_values_do_not_overshoot(void **state) {
  (void)state;
  double last = 0.0, last_slope = 0.0;
  for (double frame = 0.01; frame < 20.0; frame += 0.01) {
    const double value = eval(NP_INTERPOLATION_SMOOTH, frame), slope = (value - last) / 0.01;
    assert_true(value >= last && value <= 5.0);
    assert_near(slope, last_slope, 0.01); /* the curvature is at most 0.6 a frame² here */
    last = value, last_slope = slope;
  }
}

/* ---- Scenes ---- */

static void a_scene_is_what_it_is_in_a_frame(void **state) {
  fixture *f = *state;
  neph_output output = NEPH_OUTPUT_DEFAULT;
  assert_true(neph_scene_is_animated(f->scene));
  assert_int_equal(neph_scene_get_output(f->scene, &output), NEPH_OK);
  const char *name = neph_scene_get_cloud_name(f->scene, 0);
  assert_int_equal(neph_scene_set_frame(f->scene, 6), NEPH_OK);
  assert_near(f->scene->camera.position_m[0], 200.0, 1e-9);
  assert_near(f->scene->camera.position_m[2], 550.0, 1e-9);
  assert_near(f->scene->reach.camera_min_m[1], -3000.0, 0.0);
  assert_near(f->scene->reach.camera_max_m[2], 700.0, 0.0);
  neph_output later = NEPH_OUTPUT_DEFAULT;
  assert_int_equal(neph_scene_get_output(f->scene, &later), NEPH_OK);
  assert_ptr_equal(output.image, later.image);
  assert_ptr_equal(name, neph_scene_get_cloud_name(f->scene, 0));
  set(f, "camera.fov", "20 deg"); /* keeps frame and tracks */
  assert_near(f->scene->camera.position_m[0], 200.0, 1e-9);
  set(f, "camera.position", "[1, 2, 3]"); /* ends its track */
  assert_false(neph_scene_is_animated(f->scene));
  assert_near(f->scene->camera.position_m[0], 1.0, 0.0);
}

static void time_goes_by_frames(void **state) {
  fixture *f = *state;
  set(f, "sun.time", "2026-06-21T04:00Z");
  set(f, "sun.frame_time", "60 s");
  assert_int_equal(neph_scene_set_frame(f->scene, 31), NEPH_OK);
  const np_scene_lights by_rate = np_scene_lights_compute(f->scene, 0.7, 0.1);
  set(f, "sun.frame_time", "0 s");
  set(f, "animate.sun.time", "[[1, 2026-06-21T04:00Z], [61, 2026-06-21T07:00:00+02:00]]");
  const np_scene_lights by_track = np_scene_lights_compute(f->scene, 0.7, 0.1);
  assert_near(np_dvec3_dot(by_rate.to_sun, by_track.to_sun), 1.0, 1e-12);
  char *text;
  assert_int_equal(neph_scene_describe(f->scene, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_non_null(strstr(text, "sun.time: 2026-06-21T04:30:00.000Z\n"));
  neph_text_destroy(f->context, text);
  set(f, "frame_rate", "25");
  assert_near(np_scene_cloud_get_frame(&f->scene->clouds[0], 26).time_s, 1.0, 1e-12);
  set(f, "clouds[0].bake.frame_time", "0 s");
  assert_near(np_scene_cloud_get_frame(&f->scene->clouds[0], 26).time_s, 0.0, 0.0);
}

/* ---- Cameras from files ---- */

static neph_result load_camera(fixture *f, const char *name, const char *text, const char *keys, neph_scene **out) {
  char *folder = test_folder_create(), *path = test_path(folder, name), scene[1024];
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  (void)fputs(text, file);
  (void)fclose(file);
  (void)snprintf(scene, sizeof scene, "{camera: {resolution: [20, 10], motion: {file: \"%s\"%s}}}", path, keys);
  neph_result result = neph_scene_load_text(f->context, scene, "/scene.yaml", out);
  if (!result) result = neph_scene_set_frame(*out, 2);
  free(path);
  test_folder_destroy(folder);
  return result;
}

/* Frames are counted on, and divided into blocks: at the ends of int there is no room for that. */
static void frames_at_the_ends_of_int_are_refused(void **state) {
  fixture *f = *state;
  static const int frames[] = {INT_MAX, INT_MIN, 1000000001};
  for (size_t i = 0; i < sizeof frames / sizeof *frames; i++) {
    neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
    neph_image *image;
    assert_int_equal(neph_scene_set_frame(f->scene, frames[i]), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, "frame is ", "must be in [-1000000000, 1000000000]");
    assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
    desc.frame = frames[i];
    assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_ERROR_INVALID_ARGUMENT);
    assert_one_error(&f->log, "frame is ", "must be in [-1000000000, 1000000000]");
  }
  assert_int_equal(neph_scene_set_frame(f->scene, -1000000000), NEPH_OK);
  assert_int_equal(neph_scene_set_frame(f->scene, 1), NEPH_OK);
}

static void assert_vector(const double v[3], double x, double y, double z) {
  assert_near(v[0], x, 1e-9);
  assert_near(v[1], y, 1e-9);
  assert_near(v[2], z, 1e-9);
}

/* Half way between a camera that looks north and one that has turned by 90 deg, to the west, about the axis up. */
static void a_chan_moves_the_camera(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(
      load_camera(f, "a.chan", "1 0 5 30 0 0 0 53.13010235\n\n3\t2 7 10 0 90 0 53.13010235\n", ", unit: 10 m", &scene),
      NEPH_OK);
  assert_vector(scene->camera.position_m, 10.0, -200.0, 60.0);
  assert_int_equal(neph_scene_set_frame(scene, 1), NEPH_OK);
  assert_vector(scene->camera.look_at_m, 0.0, 700.0, 50.0);
  assert_near(tan(0.5 * scene->camera.fov_rad), 1.0, 1e-9); /* the vertical one's tangent is 1/2, of twice the height */
  assert_int_equal(neph_scene_set_frame(scene, 3), NEPH_OK);
  assert_vector(scene->camera.look_at_m, -980.0, -100.0, 70.0);
  assert_int_equal(neph_scene_set(scene, "camera.fov", "20 deg"), NEPH_OK); /* wins over the file, which is gone */
  assert_int_equal(neph_scene_set_frame(scene, 1), NEPH_ERROR_NOT_FOUND);
  neph_scene_destroy(scene);
}

/* First about z, a roll, then up about x, then about the axis up. */
static void rotations_have_an_order(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(load_camera(f, "a.chan", "1 0 0 0 30 90 20\n", "", &scene), NEPH_OK);
  const double c = 1000.0 * cos(30.0 * NP_DEGREE);
  assert_vector(scene->camera.look_at_m, -c, 0.0, 500.0);
  assert_near(scene->camera.roll_rad, -20.0 * NP_DEGREE, 1e-12);
  assert_near(scene->camera.fov_rad, 50.0 * NP_DEGREE, 1e-12); /* none in the file */
  neph_scene_destroy(scene);
}

static void a_csv_names_its_columns(void **state) {
  fixture *f = *state;
  neph_scene *scene;
  assert_int_equal(load_camera(f, "a.csv",
                               "frame,x,y,z,look_x,look_y,look_z,roll,fov\n1,0,0,0,1,2,3,10,40\n3,4,0,0,1,2,3,30,20\n",
                               ", up: z, offset: -1", &scene),
                   NEPH_OK);
  assert_vector(scene->camera.position_m, 4.0, 0.0, 0.0);
  assert_vector(scene->camera.look_at_m, 1.0, 2.0, 3.0);
  assert_near(scene->camera.roll_rad, 30.0 * NP_DEGREE, 1e-12);
  assert_near(scene->camera.fov_rad, 20.0 * NP_DEGREE, 1e-12);
  neph_scene_destroy(scene);
}

static void broken_cameras_are_refused(void **state) {
  static const char *const files[][3] = {{"a.chan", "1 2 3\n", "7 or 8 numbers"},
                                         {"a.chan", "1 0 0 0 0 0 0\n1 0 0 0 0 0 0\n", ":2: the frame is not behind"},
                                         {"a.chan", "1 0 0 0 0 0 x\n", "7 or 8 numbers"},
                                         {"a.chan", "# nothing\n", "it has no frame"},
                                         {"a.csv", "frame,x,y\n1,2,3\n", "a.csv"}};
  fixture *f = *state;
  for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
    neph_scene *scene;
    test_log_clear(&f->log);
    assert_int_equal(load_camera(f, files[i][0], files[i][1], "", &scene), NEPH_ERROR_BAD_FILE);
    assert_non_null(strstr(f->log.text, files[i][2]));
    neph_scene_destroy(scene);
  }
}

/* ---- Pictures ---- */

/* Uses the fixture's renderer, or, for another scene, a new one. */
static neph_image *render(fixture *f, neph_scene *scene, int frame) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.frame = frame;
  test_log_clear(&f->log);
  assert_int_equal(scene == f->scene ? neph_renderer_render(f->renderer, scene, &desc, &image)
                                     : neph_render_image(scene, &desc, &image),
                   NEPH_OK);
  return image;
}

static void assert_same_bits(neph_image *a, neph_image *b) {
  static const char *const names[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 4; c++)
    assert_memory_equal(neph_image_get_channel(a, names[c]), neph_image_get_channel(b, names[c]),
                        WIDTH * HEIGHT * sizeof(float));
}

/* Frames in any order are those of a scene of their own. */
static void assert_frames_stand_alone(fixture *f, const char *text, const int *frames, int count, unsigned solves_max) {
  unsigned solves = 0;
  for (int i = 0; i < count; i++) {
    neph_scene *alone;
    assert_int_equal(neph_scene_load_text(f->context, text, "dir/scene.yaml", &alone), NEPH_OK);
    neph_image *two = render(f, f->scene, frames[i]);
    solves += !strstr(f->log.text, "multiple scattering: reused");
    neph_image *one = render(f, alone, frames[i]);
    assert_same_bits(one, two);
    neph_image_destroy(one);
    neph_image_destroy(two);
    neph_scene_destroy(alone);
  }
  assert_in_range(solves, 1, solves_max);
}

static void a_frame_alone_is_that_of_a_sequence(void **state) {
  static const int frames[] = {1, 2, 9, 5, 11};
  assert_frames_stand_alone(*state, moving, frames, 5, 1);
}

/* Under a sun that turns by 0.12 deg a frame; frames 0 to 8 are a block of light_reuse, 1 deg. */
static const char rising[] =
    "{camera: {position: [0, -3 km, 400 m], look_at: [0, 0, 800 m], fov: 40 deg, resolution: [24, 16]},"
    " sun: {azimuth: 140 deg}, animate: {sun.elevation: [[-100, -10 deg], [100, 14 deg]]},"
    " clouds: [{name: a, bake: {preset: cumulus_mediocris, model: hero, seed: 3, extent: [800 m, 800 m], voxel: 50 "
    "m}}],"
    " render: {samples: 4}, output: {pixel_type: float}}";

static int set_up_rising(void **state) { return set_up_scene(state, 2, rising); }

static void light_is_interpolated_under_a_moving_sun(void **state) {
  static const int frames[] = {5, 1, 7};
  assert_frames_stand_alone(*state, rising, frames, 3, 3);
}

static void light_is_solved_for_at_the_ends_of_blocks_alone(void **state) {
  fixture *f = *state;
  neph_image_destroy(render(f, f->scene, 3));
  assert_non_null(strstr(f->log.text, "solved for at frame 0"));
  assert_non_null(strstr(f->log.text, "solved for at frame 8"));
  neph_image_destroy(render(f, f->scene, 6));
  assert_null(strstr(f->log.text, "solved for"));
  neph_image_destroy(render(f, f->scene, 9));
  assert_null(strstr(f->log.text, "solved for at frame 8"));
  assert_non_null(strstr(f->log.text, "solved for at frame 16"));
  set(f, "clouds[0].bake.seed", "4");
  neph_image_destroy(render(f, f->scene, 9));
  assert_non_null(strstr(f->log.text, "solved for at frame 8"));
}

/* The middle of a block, at 2.5 deg of sun, against a solution of its own: some 0.1 % are measured. */
static void interpolated_light_is_that_of_the_frame(void **state) {
  fixture *f = *state;
  neph_image *between = render(f, f->scene, 4);
  set(f, "render.light_reuse", "0 deg");
  neph_image *own = render(f, f->scene, 4);
  assert_null(strstr(f->log.text, "solved for at frame"));
  const float *a = neph_image_get_channel(between, "G"), *b = neph_image_get_channel(own, "G");
  double difference = 0.0, sum = 0.0;
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    difference += fabs((double)(a[i] - b[i]));
    sum += (double)b[i];
  }
  assert_true(difference > 0.0);
  assert_true(difference < 0.005 * sum);
  neph_image_destroy(between);
  neph_image_destroy(own);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_between_key_frames),
      cmocka_unit_test(smooth_values_do_not_overshoot),
      cmocka_unit_test_setup_teardown(a_scene_is_what_it_is_in_a_frame, set_up, tear_down),
      cmocka_unit_test_setup_teardown(frames_at_the_ends_of_int_are_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(time_goes_by_frames, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_chan_moves_the_camera, set_up, tear_down),
      cmocka_unit_test_setup_teardown(rotations_have_an_order, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_csv_names_its_columns, set_up, tear_down),
      cmocka_unit_test_setup_teardown(broken_cameras_are_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_frame_alone_is_that_of_a_sequence, set_up, tear_down),
      cmocka_unit_test_setup_teardown(light_is_interpolated_under_a_moving_sun, set_up_rising, tear_down),
      cmocka_unit_test_setup_teardown(light_is_solved_for_at_the_ends_of_blocks_alone, set_up_rising, tear_down),
      cmocka_unit_test_setup_teardown(interpolated_light_is_that_of_the_frame, set_up_rising, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
