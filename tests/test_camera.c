/* SPDX-License-Identifier: Apache-2.0 */
#include "test_scenes.h"

#include "core/random.h"
#include "core/units.h"
#include "scene/camera.h"

static int set_up(void **state) { return set_up_scene(state, 1, "{}"); }

static np_camera make_camera(fixture *f, const char *position, const char *look_at, const char *roll) {
  np_camera camera;
  set(f, "camera.position", position);
  set(f, "camera.look_at", look_at);
  set(f, "camera.roll", roll);
  set(f, "camera.fov", "90 deg");
  assert_int_equal(np_camera_init(f->scene, 200, 100, NEPH_EYE_CENTRE, &camera), NEPH_OK);
  return camera;
}

/* A float direction of unit length, through two or three products: a few 2⁻²⁴. */
static const double tolerance = 3e-7;

static void assert_direction(const np_camera *camera, float x, float y, double dx, double dy, double dz) {
  np_vec3 d;
  assert_true(np_camera_get_direction(camera, x, y, &d));
  assert_near((double)np_vec3_length(d), 1, tolerance);
  assert_near((double)d.x, dx, tolerance);
  assert_near((double)d.y, dy, tolerance);
  assert_near((double)d.z, dz, tolerance);
}

static void test_rays_fill_the_angle_of_view(void **state) {
  np_camera camera = make_camera(*state, "[1, 2, 3]", "[1, 12, 3]", "0");
  const double s = sqrt(0.5), t = sqrt(0.8), u = sqrt(0.2);
  assert_direction(&camera, 100, 50, 0, 1, 0);
  assert_direction(&camera, 200, 50, s, s, 0); /* 90° across: 45° to the right edge */
  assert_direction(&camera, 0, 50, -s, s, 0);
  assert_direction(&camera, 100, 0, 0, t, u); /* half as high: atan ½ to the top */
  assert_near(camera.origin.x, 1, 0);
  assert_near(camera.origin.z, 3, 0);
}

static void test_roll_turns_the_camera_clockwise(void **state) {
  np_camera camera = make_camera(*state, "[0, 0, 0]", "[0, 10, 0]", "90 deg");
  assert_near((double)camera.up.x, 1, tolerance); /* its top points right, east */
  assert_near((double)camera.right.z, -1, tolerance);
}

static void test_straight_down_has_north_at_the_top(void **state) {
  np_camera camera = make_camera(*state, "[0, 0, 1 km]", "[0, 0, 0]", "0");
  assert_direction(&camera, 100, 50, 0, 0, -1);
  assert_near((double)camera.up.y, 1, tolerance);
  assert_near((double)camera.right.x, 1, tolerance);
}

static void test_straight_up_has_south_at_the_top(void **state) {
  np_camera camera = make_camera(*state, "[0, 0, 0]", "[0, 0, 1 km]", "0");
  assert_direction(&camera, 100, 50, 0, 0, 1);
  assert_near((double)camera.up.y, -1, tolerance);
}

static void test_frame_is_right_handed_and_unit(void **state) {
  np_camera camera = make_camera(*state, "[10, -20, 3 km]", "[4 km, 7 km, 1 km]", "33 deg");
  np_vec3 back = np_vec3_cross(camera.right, camera.up);
  assert_near((double)np_vec3_dot(back, camera.back), 1, tolerance);
  assert_near((double)np_vec3_dot(camera.right, camera.up), 0, tolerance);
}

static void multiply(const float m[16], const double p[3], double out[4]) {
  for (int column = 0; column < 4; column++) {
    out[column] = (double)m[12 + column];
    for (int row = 0; row < 3; row++) out[column] += p[row] * (double)m[4 * row + column];
  }
}

/* A world point on the ray of pixel (x, y) must land on it again. */
static void assert_lands(const np_camera *camera, const float ndc_matrix[16], float x, float y) {
  np_vec3 d;
  assert_true(np_camera_get_direction(camera, x, y, &d));
  np_dvec3 p = np_dvec3_along(camera->origin, d, 5000);
  double ndc[4];
  multiply(ndc_matrix, (const double[3]){p.x, p.y, p.z}, ndc);
  /* The matrix holds the origin in float, 4 km ± 2e-4 m: 1e-7 of the distance, and as much for the axes. */
  assert_near(ndc[0] / ndc[3], (double)(x / 200), 1e-6);
  assert_near(ndc[1] / ndc[3], (double)(y / 100), 1e-6);
}

static void test_matrices_follow_openexr(void **state) {
  np_camera camera = make_camera(*state, "[1 km, -2 km, 3 km]", "[4 km, 7 km, 1 km]", "20 deg");
  float to_camera[16], to_ndc[16];
  assert_true(np_camera_get_matrices(&camera, to_camera, to_ndc));
  double p[4];
  multiply(to_camera, (const double[3]){4000, 7000, 1000}, p);
  const double distance = sqrt(9e6 + 81e6 + 4e6);
  /* 10 km in float axes of 2⁻²⁴ each, three terms. */
  assert_near(p[0], 0, 2e-3);
  assert_near(p[1], 0, 2e-3);
  assert_near(p[2], distance, 2e-3);
  assert_near(p[3], 1, 0);
  assert_lands(&camera, to_ndc, 0, 0);
  assert_lands(&camera, to_ndc, 200, 100);
  assert_lands(&camera, to_ndc, 37.5f, 80);
}

static void test_no_picture_is_refused(void **state) {
  fixture *f = *state;
  np_camera camera;
  assert_int_equal(np_camera_init(f->scene, 0, 10, NEPH_EYE_CENTRE, &camera), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "0 x 10", "1 to 65536");
}

static void assert_sun(fixture *f, const char *elevation, const char *azimuth, double x, double y, double z) {
  set(f, "sun.elevation", elevation);
  set(f, "sun.azimuth", azimuth);
  const np_dvec3 d = np_scene_get_sun_direction(f->scene, 0, 0);
  assert_near(d.x, x, 1e-15); /* one rounding of cos and sin each */
  assert_near(d.y, y, 1e-15);
  assert_near(d.z, z, 1e-15);
}

static void test_sun_stands_clockwise_from_north(void **state) {
  fixture *f = *state;
  assert_sun(f, "0 deg", "0 deg", 0, 1, 0);
  assert_sun(f, "0 deg", "90 deg", 1, 0, 0);
  assert_sun(f, "30 deg", "180 deg", 0, -sqrt(0.75), 0.5);
  assert_sun(f, "90 deg", "77 deg", 0, 0, 1);
}

/* The sun at its transit on the longest day is 90° − 44.27° + 23.44° high, in the south. Transit is 71.3 times 4
 * minutes after noon, and 1.9 more by the equation of time: 16:47 UTC. An error of a minute moves the azimuth by 0.7°.
 */
static void test_sun_stands_where_time_and_place_say(void **state) {
  fixture *f = *state;
  set(f, "sun.time", "2026-06-21T18:47+02:00");
  const np_dvec3 d = np_scene_get_sun_direction(f->scene, 44.27 * NP_DEGREE, -71.3 * NP_DEGREE);
  assert_near(asin(d.z) / NP_DEGREE, 90 - 44.27 + 23.44, 0.02);
  assert_near(atan2(d.x, -d.y) / NP_DEGREE, 0, 0.7);
}

static bool has_point_in_picture(const np_camera *c, np_dvec3 low, np_dvec3 high) {
  const np_dvec3 right = np_vec3_to_double(c->right), up = np_vec3_to_double(c->up), back = np_vec3_to_double(c->back),
                 size = np_dvec3_subtract(high, low);
  bool has_point = false;
  for (int i = 0; i < 1000; i++) {
    const np_dvec3 at = np_dvec3_make(i % 10 / 9.0 * size.x, i / 10 % 10 / 9.0 * size.y, i / 100 / 9.0 * size.z);
    const np_dvec3 d = np_dvec3_subtract(np_dvec3_add(low, at), c->origin);
    const double depth = -np_dvec3_dot(d, back);
    has_point = has_point || (fabs(np_dvec3_dot(d, right)) < depth * (double)c->tan_half_width &&
                              fabs(np_dvec3_dot(d, up)) < depth * (double)c->tan_half_height);
  }
  return has_point;
}

static np_dvec3 draw_point(np_random *random, double low, double size) {
  const double x = np_random_double(random), y = np_random_double(random), z = np_random_double(random);
  return np_dvec3_make(low + size * x, low + size * y, low + size * z);
}

/* A box that is called unseen has no point in the picture. Of those seen, points a ninth of a box apart miss few: less
 * than one in twenty. */
static void test_boxes_in_the_picture_are_seen(void **state) {
  const np_camera camera = make_camera(*state, "[10, -20, 5]", "[13, -2, 9]", "17 deg");
  np_random random = np_random_start(5, 0, 0, 0, 0);
  unsigned seen = 0, unseen = 0, missed = 0;
  for (int n = 0; n < 4000; n++) {
    const np_dvec3 low = draw_point(&random, -100.0, 200.0), high = np_dvec3_add(low, draw_point(&random, 0.0, 60.0));
    const bool is_seen = np_camera_sees_box(&camera, low, high), has_point = has_point_in_picture(&camera, low, high);
    assert_true(is_seen || !has_point);
    seen += is_seen;
    unseen += !is_seen;
    missed += is_seen && !has_point;
  }
  print_message("%u boxes seen, %u of them between points, %u unseen\n", seen, missed, unseen);
  assert_true(seen > 400 && unseen > 1000 && 20 * missed < seen);
}

static void test_a_point_is_a_box(void **state) {
  const np_camera camera = make_camera(*state, "[0, 0, 0]", "[0, 10, 0]", "0");
  const np_dvec3 ahead = np_dvec3_make(0, 5, 0), behind = np_dvec3_make(0, -5, 0);
  assert_true(np_camera_sees_box(&camera, ahead, ahead));
  assert_false(np_camera_sees_box(&camera, behind, behind));
  assert_true(np_camera_sees_box(&camera, np_dvec3_make(-1, -1, -1), np_dvec3_make(1, 1, 1))); /* around the camera */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_rays_fill_the_angle_of_view, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_roll_turns_the_camera_clockwise, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_straight_down_has_north_at_the_top, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_straight_up_has_south_at_the_top, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_frame_is_right_handed_and_unit, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_matrices_follow_openexr, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_boxes_in_the_picture_are_seen, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_point_is_a_box, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_no_picture_is_refused, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_sun_stands_clockwise_from_north, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_sun_stands_where_time_and_place_say, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
