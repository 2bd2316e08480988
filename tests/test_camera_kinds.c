/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras of every kind: known points, solid angles, the thin lens, eyes. */
#include "test_scenes.h"

#include "core/random.h"
#include "core/units.h"
#include "scene/camera.h"

static int set_up(void **state) {
  return set_up_scene(state, 1, "{camera: {position: [0, 0, 100], look_at: [0, 1 km, 100]}}");
}

static const char *const kinds[] = {"perspective", "orthographic", "equirectangular", "fisheye"};

static np_camera make(fixture *f, const char *kind, unsigned width, unsigned height) {
  np_camera camera;
  set(f, "camera.kind", kind);
  assert_int_equal(np_camera_init(f->scene, width, height, NEPH_EYE_CENTRE, &camera), NEPH_OK);
  return camera;
}

static np_vec3 get_direction(const np_camera *camera, float x, float y) {
  np_film_ray ray;
  assert_true(np_camera_start_ray(camera, x, y, 0.5f, 0.5f, &ray));
  return ray.direction;
}

/* Float directions: a few 2⁻²⁴, times π where an angle is formed. */
static const double tolerance = 6e-7;

static void assert_direction(const np_camera *camera, float x, float y, double dx, double dy, double dz) {
  const np_vec3 d = get_direction(camera, x, y);
  assert_near((double)d.x, dx, tolerance);
  assert_near((double)d.y, dy, tolerance);
  assert_near((double)d.z, dz, tolerance);
}

/* North in the middle, east a quarter to the right, south at both edges, the zenith at the top. */
static void an_equirectangular_picture_is_the_sphere(void **state) {
  fixture *f = *state;
  const np_camera camera = make(f, "equirectangular", 200, 100);
  assert_direction(&camera, 100, 50, 0, 1, 0);
  assert_direction(&camera, 150, 50, 1, 0, 0);
  assert_direction(&camera, 50, 50, -1, 0, 0);
  assert_direction(&camera, 0, 50, 0, -1, 0);
  assert_direction(&camera, 200, 50, 0, -1, 0);
  assert_direction(&camera, 37, 0, 0, 0, 1);
  assert_direction(&camera, 100, 75, 0, sqrt(0.5), -sqrt(0.5));
}

/* Whatever the height of what is looked at. */
static void an_equirectangular_picture_is_level(void **state) {
  fixture *f = *state;
  set(f, "camera.look_at", "[1 km, 0, 3 km]");
  const np_camera camera = make(f, "equirectangular", 200, 100);
  assert_direction(&camera, 100, 50, 1, 0, 0);
  assert_direction(&camera, 150, 50, 0, -1, 0);
  assert_direction(&camera, 100, 0, 0, 0, 1);
}

/* Half way to the rim half the angle; no ray beyond it. */
static void a_fisheye_is_equidistant(void **state) {
  fixture *f = *state;
  const np_camera camera = make(f, "fisheye", 300, 100);
  assert_direction(&camera, 150, 50, 0, 1, 0);
  assert_direction(&camera, 175, 50, sqrt(0.5), sqrt(0.5), 0);
  assert_direction(&camera, 199.999f, 50, 1, 3.14e-5, 0);
  assert_direction(&camera, 150, 25, 0, sqrt(0.5), sqrt(0.5));
  np_film_ray ray;
  assert_false(np_camera_start_ray(&camera, 201, 50, 0.5f, 0.5f, &ray));
  assert_false(np_camera_start_ray(&camera, 150, -1, 0.5f, 0.5f, &ray));
}

static void orthographic_rays_are_parallel(void **state) {
  fixture *f = *state;
  set(f, "camera.orthographic_width", "400 m");
  const np_camera camera = make(f, "orthographic", 200, 100);
  np_film_ray ray;
  assert_true(np_camera_start_ray(&camera, 200, 0, 0.5f, 0.5f, &ray));
  assert_near(ray.origin.x, 200, 1e-4); /* float metres */
  assert_near(ray.origin.y, 0, 1e-4);
  assert_near(ray.origin.z, 200, 1e-4);
  assert_direction(&camera, 200, 0, 0, 1, 0);
  assert_false(np_camera_has_centre(&camera));
}

/* Places along a ray are seen where the ray came from, at the depth they have there. */
static void places_fall_where_their_rays_came_from(void **state) {
  fixture *f = *state;
  set(f, "camera.look_at", "[3 km, 4 km, 1 km]");
  set(f, "camera.roll", "20 deg");
  for (int k = 0; k < 4; k++) {
    const bool is_flat = k < 2;
    if (is_flat) set(f, "camera.shift", "[0.1, -0.2]");
    const np_camera camera = make(f, kinds[k], 240, 160);
    np_random random = np_random_start(3, 0, 0, 0, 0);
    unsigned count = 0;
    for (int n = 0; n < 200; n++) {
      const float x = 240.0f * np_random_float(&random), y = 160.0f * np_random_float(&random);
      np_film_ray ray;
      if (!np_camera_start_ray(&camera, x, y, 0.5f, 0.5f, &ray)) continue;
      double film[2], depth;
      assert_true(np_camera_project(&camera, np_dvec3_along(ray.origin, ray.direction, 5000.0), film, &depth));
      /* 5 km and float directions: 6e-7 of 240 pixels, and ten times that near an equirectangular pole. */
      assert_near(film[0], (double)x, 2e-3);
      assert_near(film[1], (double)y, 2e-3);
      assert_near_relative(depth, np_camera_get_depth(&camera, ray.direction, 5000.0), 1e-6);
      if (np_camera_has_centre(&camera)) {
        assert_true(np_camera_project_direction(&camera, np_vec3_to_double(ray.direction), film));
        assert_near(film[0], (double)x, 2e-3);
      }
      count++;
    }
    assert_true(count > 90); /* a fisheye's circle is half of this picture */
  }
}

static double sum_solid_angles(const np_camera *camera) {
  double sum = 0.0;
  for (unsigned y = 0; y < camera->height; y++)
    for (unsigned x = 0; x < camera->width; x++) sum += np_camera_get_pixel_sr(camera, x, y);
  return sum;
}

/* The sphere; half of it; a pyramid of 90° by 2·atan ½, 4·asin(sin a·sin b) of the half angles' dihedral form. */
static void pixels_add_up_to_solid_angles(void **state) {
  fixture *f = *state;
  np_camera camera = make(f, "equirectangular", 128, 64);
  assert_near_relative(sum_solid_angles(&camera), 4.0 * NP_PI, 1e-12);
  camera = make(f, "fisheye", 400, 400);
  assert_near_relative(sum_solid_angles(&camera), 2.0 * NP_PI,
                       2e-3); /* whole pixels at the rim: √(2π·200) of 2π·200² */
  set(f, "camera.fov", "90 deg");
  camera = make(f, "perspective", 400, 200);
  const double a = sin(atan(1.0)), b = sin(atan(0.5));
  assert_near_relative(sum_solid_angles(&camera), 4.0 * asin(a * b), 1e-4); /* the midpoint rule of 400 pixels */
}

static void a_focal_length_is_an_angle(void **state) {
  fixture *f = *state;
  set(f, "camera.focal_length", "18 mm");
  assert_near(np_scene_camera_get_fov_rad(&f->scene->camera), 0.5 * NP_PI, 1e-12);
  set(f, "camera.sensor", "72 mm");
  assert_near(np_scene_camera_get_fov_rad(&f->scene->camera), 2.0 * atan(2.0), 1e-12);
}

/* Half a width to the right: the middle is where the right edge was; half a height up, the top edge. */
static void a_shift_moves_the_window(void **state) {
  fixture *f = *state;
  const np_camera still = make(f, "perspective", 200, 100);
  const np_vec3 right = get_direction(&still, 200, 50), top = get_direction(&still, 100, 0);
  set(f, "camera.shift", "[0.5, 0]");
  np_camera camera = make(f, "perspective", 200, 100);
  assert_direction(&camera, 100, 50, (double)right.x, (double)right.y, (double)right.z);
  set(f, "camera.shift", "[0, 0.25]");
  camera = make(f, "perspective", 200, 100);
  assert_direction(&camera, 100, 50, (double)top.x, (double)top.y, (double)top.z);
}

/* Shifted matrices land where shifted rays go; a parallel picture's w is 1. */
static void matrices_know_shift_and_parallel_rays(void **state) {
  fixture *f = *state;
  set(f, "camera.shift", "[0.2, -0.1]");
  set(f, "camera.look_at", "[300, 900, 400]");
  for (int k = 0; k < 2; k++) {
    const np_camera camera = make(f, kinds[k], 200, 100);
    float to_camera[16], to_ndc[16];
    assert_true(np_camera_get_matrices(&camera, to_camera, to_ndc));
    np_film_ray ray;
    assert_true(np_camera_start_ray(&camera, 30, 80, 0.5f, 0.5f, &ray));
    const np_dvec3 p = np_dvec3_along(ray.origin, ray.direction, 2000.0);
    double ndc[4];
    for (int c = 0; c < 4; c++)
      ndc[c] =
          p.x * (double)to_ndc[c] + p.y * (double)to_ndc[4 + c] + p.z * (double)to_ndc[8 + c] + (double)to_ndc[12 + c];
    assert_near(ndc[0] / ndc[3], 0.15, 1e-6); /* float matrices */
    assert_near(ndc[1] / ndc[3], 0.8, 1e-6);
    assert_true((k == 0) != (fabs(ndc[3] - 1.0) < 1e-6));
  }
  float unused[16];
  const np_camera camera = make(f, "fisheye", 200, 100);
  assert_false(np_camera_get_matrices(&camera, unused, unused));
}

/* A lens of 50 mm at f/0.5, 100 mm across, in focus at 20 m. */
static np_camera make_lens(fixture *f) {
  set(f, "camera.focal_length", "50 mm");
  set(f, "camera.f_stop", "0.5");
  set(f, "camera.focus_distance", "20 m");
  return make(f, "perspective", 360, 200);
}

static void rays_of_a_lens_meet_in_focus(void **state) {
  const np_camera camera = make_lens(*state);
  np_film_ray middle;
  assert_true(np_camera_start_ray(&camera, 77, 33, 0.5f, 0.5f, &middle));
  assert_near(np_dvec3_length(np_dvec3_subtract(middle.origin, camera.origin)), 0.0, 1e-7);
  const double reach = -20.0 / (double)np_vec3_dot(middle.direction, camera.back);
  const np_dvec3 focus = np_dvec3_along(middle.origin, middle.direction, reach);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int n = 0; n < 100; n++) {
    np_film_ray ray;
    assert_true(np_camera_start_ray(&camera, 77, 33, np_random_float(&random), np_random_float(&random), &ray));
    assert_true(np_dvec3_length(np_dvec3_subtract(ray.origin, camera.origin)) <= 0.05 + 1e-6);
    const np_dvec3 to = np_dvec3_subtract(focus, ray.origin), d = np_vec3_to_double(ray.direction);
    const np_dvec3 off = np_dvec3_subtract(to, np_dvec3_scale(d, np_dvec3_dot(to, d)));
    assert_near(np_dvec3_length(off), 0.0, 1e-5); /* float directions over 20 m */
  }
}

/* The thin lens: a point at Z in front of one in focus at F blurs to A·|Z − F|/Z·f/(F − f) on a sensor f·F/(F − f)
 * behind it. Seen by its rays: those from a point through the rim of the lens come from a circle of film positions. */
static void a_circle_of_confusion_is_that_of_the_thin_lens(void **state) {
  const np_camera camera = make_lens(*state);
  const double depths[] = {5.0, 10.0, 40.0, 1e9};
  for (int i = 0; i < 4; i++) {
    const double aperture = 0.1, sensor_m = 0.036, focal = 0.05, z = depths[i];
    /* Film positions are those of the pinhole image, whose plane is at f: the field of view does not breathe. */
    const double expected = aperture * fabs(z - 20.0) / z * focal / 20.0 * 360.0 / sensor_m;
    assert_near_relative(np_camera_get_confusion(&camera, z), expected, 1e-6);
    double film[2], unused, lowest = HUGE_VAL, highest = -HUGE_VAL;
    for (int side = -1; side <= 1; side += 2) {
      /* A ray from the lens at `side` radii towards the point: through the plane of focus, then to the film. */
      const np_dvec3 from = np_dvec3_make(0.05 * side, 0.0, 100.0), point = np_dvec3_make(0.0, z, 100.0);
      const np_dvec3 in_focus =
          np_dvec3_add(from, np_dvec3_scale(np_dvec3_subtract(point, from), 20.0 / (point.y - from.y)));
      assert_true(np_camera_project(&camera, in_focus, film, &unused));
      lowest = fmin(lowest, film[0]);
      highest = fmax(highest, film[0]);
    }
    assert_near_relative(highest - lowest, expected, 1e-5); /* the float tangent of the film */
  }
}

/* Places even over a disk of radius 1 have a mean square of ½ from its middle; over a hexagon of that circumradius,
 * (2 + cos 60°·2)/… = 5/12. 10⁴ draws leave 1 %. */
static void apertures_are_even(void **state) {
  fixture *f = *state;
  const char *const blades[] = {"round", "6"};
  const double mean_squares[] = {0.5, 5.0 / 12.0};
  for (int i = 0; i < 2; i++) {
    set(f, "camera.blades", blades[i]);
    const np_camera camera = make_lens(f);
    np_random random = np_random_start(2, 0, 0, 0, 0);
    double sum = 0.0, x = 0.0, y = 0.0;
    for (int n = 0; n < 10000; n++) {
      float at[2];
      np_camera_sample_aperture(&camera, np_random_float(&random), np_random_float(&random), at);
      sum += (double)(at[0] * at[0] + at[1] * at[1]) / 10000;
      x += (double)at[0] / 10000;
      y += (double)at[1] / 10000;
    }
    assert_near_relative(sum, mean_squares[i], 0.02);
    assert_near(x, 0.0, 0.02);
    assert_near(y, 0.0, 0.02);
  }
}

/* Between the eyes a point at Z moves by W/(2·tan)·i·(1/Z − 1/C) pixels: none at the convergence, to the left in the
 * right eye's picture before it. */
static void eyes_see_disparity(void **state) {
  fixture *f = *state;
  set(f, "camera.fov", "60 deg");
  set(f, "camera.stereo.interaxial", "0.5 m");
  set(f, "camera.stereo.convergence", "50 m");
  const double depths[] = {10.0, 50.0, 200.0, 1e6};
  np_camera eyes[2];
  for (int e = 0; e < 2; e++)
    assert_int_equal(np_camera_init(f->scene, 400, 200, e ? NEPH_EYE_RIGHT : NEPH_EYE_LEFT, &eyes[e]), NEPH_OK);
  assert_near(eyes[1].origin.x - eyes[0].origin.x, 0.5, 1e-9);
  for (int i = 0; i < 4; i++) {
    double left[2], right[2], depth;
    const np_dvec3 p = np_dvec3_make(1.0, depths[i], 102.0);
    assert_true(np_camera_project(&eyes[0], p, left, &depth));
    assert_true(np_camera_project(&eyes[1], p, right, &depth));
    const double expected = 200.0 / tan(30.0 * NP_DEGREE) * 0.5 * (1.0 / depths[i] - 1.0 / 50.0);
    assert_near(left[0] - right[0], expected, 1e-4); /* float shifts of 5e-3, 400 pixels */
    assert_near(left[1], right[1], 1e-9);
  }
}

/* EV 15 at ISO 100: f/16 at 1/128 s, the sunny sixteen. */
static void exposure_is_photographic(void **state) {
  fixture *f = *state;
  double ev;
  set(f, "camera.f_stop", "16");
  set(f, "camera.shutter", "0.0078125 s");
  assert_false(np_scene_camera_get_ev100(&f->scene->camera, &ev));
  set(f, "camera.iso", "100");
  assert_true(np_scene_camera_get_ev100(&f->scene->camera, &ev));
  assert_near(ev, 15.0, 1e-12);
  set(f, "camera.iso", "400");
  assert_true(np_scene_camera_get_ev100(&f->scene->camera, &ev));
  assert_near(ev, 13.0, 1e-12);
}

static void boxes_are_seen_by_every_kind(void **state) {
  fixture *f = *state;
  const np_dvec3 ahead_low = np_dvec3_make(-50, 900, 50), ahead_high = np_dvec3_make(50, 1000, 150);
  const np_dvec3 behind_low = np_dvec3_make(-50, -1000, 50), behind_high = np_dvec3_make(50, -900, 150);
  const np_dvec3 aside_low = np_dvec3_make(30e3, 900, 50), aside_high = np_dvec3_make(31e3, 1000, 150);
  for (int k = 0; k < 4; k++) {
    const np_camera camera = make(f, kinds[k], 200, 200);
    assert_true(np_camera_sees_box(&camera, ahead_low, ahead_high));
    assert_int_equal(np_camera_sees_box(&camera, behind_low, behind_high), k == 2);
    assert_int_equal(np_camera_sees_box(&camera, aside_low, aside_high), k >= 2);
  }
}

/* Calls and keys make one camera. */
static void a_described_camera_is_that_of_keys(void **state) {
  fixture *f = *state;
  neph_camera_desc desc = NEPH_CAMERA_DESC_DEFAULT;
  desc.has_focal_length = true;
  desc.focal_length_m = 0.035;
  desc.sensor_m = 0.024;
  desc.shift[1] = 0.25;
  desc.near_m = 2.0;
  desc.far_m = 3000.0;
  desc.f_stop = 2.8;
  desc.focus_distance_m = 12.0;
  desc.blade_count = 7;
  desc.has_exposure = true;
  desc.is_stereo = true;
  desc.convergence_m = 20.0;
  assert_int_equal(neph_scene_set_camera(f->scene, &desc), NEPH_OK);
  const np_scene_camera *camera = &f->scene->camera;
  double ev;
  assert_near_relative(np_scene_camera_get_fov_rad(camera), 2.0 * atan(12.0 / 35.0), 1e-12);
  assert_near(camera->shift[1], 0.25, 0.0);
  assert_true(camera->has_lens && camera->is_stereo && neph_scene_is_stereo(f->scene));
  assert_near(camera->far_m - camera->near_m, 2998.0, 0.0);
  assert_near(camera->focus_distance_m, 12.0, 0.0);
  assert_int_equal(camera->blade_count, 7);
  assert_near(camera->interaxial_m + camera->convergence_m, 20.065, 1e-12);
  assert_true(np_scene_camera_get_ev100(camera, &ev));
  desc = (neph_camera_desc)NEPH_CAMERA_DESC_DEFAULT;
  desc.kind = NEPH_CAMERA_FISHEYE;
  desc.fisheye_fov_rad = 3.5;
  assert_int_equal(neph_scene_set_camera(f->scene, &desc), NEPH_OK);
  assert_near(f->scene->camera.fisheye_fov_rad, 3.5, 1e-12);
  assert_false(f->scene->camera.has_lens || f->scene->camera.is_stereo);
  desc.kind = (neph_camera_kind)9;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_set_camera(f->scene, &desc), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "camera.kind is unknown, must be perspective, orthographic, equirectangular or fisheye",
                   "");
}

static void nonsense_is_refused(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *words[2];
  } bad[] = {
      {"camera.focal_length", "1 mm", {"camera.focal_length is 1 mm, must be at least 1.57 mm", "fisheye"}},
      {"camera.far", "1 m", {"camera.far is 1 m, must be above camera.near, 2 m", ""}},
      {"camera.focus_distance", "20 mm", {"camera.focus_distance is 0.02 m away", "focal length, 0.0386 m"}},
      {"camera.kind", "fisheye", {"camera.stereo goes with camera.kind perspective alone", ""}},
  };
  static const char *const before[][2] = {
      {"camera.roll", "0 deg"}, {"camera.near", "2 m"}, {"camera.f_stop", "2"}, {"camera.stereo.eye", "left"}};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    fixture *g = NULL;
    assert_int_equal(set_up((void **)(void *)&g), 0);
    set(g, before[i][0], before[i][1]);
    set(g, bad[i].key, bad[i].value);
    test_log_clear(&g->log);
    assert_int_equal(neph_scene_check(g->scene), NEPH_ERROR_BAD_SCENE);
    assert_one_error(&g->log, bad[i].words[0], bad[i].words[1]);
    void *taken = g;
    (void)tear_down(&taken);
  }
  assert_int_equal(neph_scene_set(f->scene, "camera.fov", "200 deg"), NEPH_ERROR_BAD_SCENE);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(an_equirectangular_picture_is_the_sphere, set_up, tear_down),
      cmocka_unit_test_setup_teardown(an_equirectangular_picture_is_level, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_fisheye_is_equidistant, set_up, tear_down),
      cmocka_unit_test_setup_teardown(orthographic_rays_are_parallel, set_up, tear_down),
      cmocka_unit_test_setup_teardown(places_fall_where_their_rays_came_from, set_up, tear_down),
      cmocka_unit_test_setup_teardown(pixels_add_up_to_solid_angles, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_focal_length_is_an_angle, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_shift_moves_the_window, set_up, tear_down),
      cmocka_unit_test_setup_teardown(matrices_know_shift_and_parallel_rays, set_up, tear_down),
      cmocka_unit_test_setup_teardown(rays_of_a_lens_meet_in_focus, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_circle_of_confusion_is_that_of_the_thin_lens, set_up, tear_down),
      cmocka_unit_test_setup_teardown(apertures_are_even, set_up, tear_down),
      cmocka_unit_test_setup_teardown(eyes_see_disparity, set_up, tear_down),
      cmocka_unit_test_setup_teardown(exposure_is_photographic, set_up, tear_down),
      cmocka_unit_test_setup_teardown(boxes_are_seen_by_every_kind, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_described_camera_is_that_of_keys, set_up, tear_down),
      cmocka_unit_test_setup_teardown(nonsense_is_refused, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
