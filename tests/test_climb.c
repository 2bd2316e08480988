/* SPDX-License-Identifier: Apache-2.0 */
/* Places and sizes: a camera that climbs from a man's height to 400 km sees the horizon, hills and clouds move
 * smoothly; a scene looks the same wherever it stands, and as large as it may be.
 */
#include "test_scenes.h"
#include "test_stability_page.h"
#include "test_world.h"

#include <nephos/nephos.h>

static test_page page;
static bool is_long;

static const double planet_radius_m = 6360e3, first_m = 1.7, last_m = 400e3;

static double get_altitude(int step, int count) { return first_m * pow(last_m / first_m, (double)step / (count - 1)); }

/* ---- Rays ---- */

/* Hills 24 km wide under a deck of cloud, 100 m voxels from 1 km up. */
static void start_planet(test_world *w, neph_terrain **out_terrain) {
  *w = (test_world){0};
  test_world_init(w, test_context_create(2, NULL));
  test_cloud cloud = test_cloud_make(test_full, 1.0f, np_phase_isotropic());
  cloud.step_m = np_dvec3_make(100.0, 100.0, 25.0);
  cloud.middle_m = np_dvec3_make(0.0, 6e3, 1e3 + 0.5 * 25.0 * (TEST_EDGE - 1));
  assert_int_equal(test_world_add(w, cloud), NEPH_OK);
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 129;
  assert_int_equal(neph_terrain_create_ridges(w->context, &ridges, NULL, out_terrain), NEPH_OK);
  w->world.terrain = *out_terrain;
  np_terrain_get_bounds(*out_terrain, &w->world.terrain_min, &w->world.terrain_max);
  w->world.has_planet = true;
  w->world.planet_radius_m = planet_radius_m;
}

/* The zenith angle of the horizon towards the west, beyond all hills, by halving. */
static double search_horizon(const test_world *w, np_dvec3 eye) {
  double low = 0.5 * NP_PI, high = 0.75 * NP_PI;
  np_ground_hit hit;
  for (int k = 0; k < 40; k++) {
    const double middle = 0.5 * (low + high);
    const np_vec3 d = np_dvec3_to_float(np_dvec3_make(-sin(middle), 0.0, cos(middle)));
    *(np_world_intersect_ground(&w->world, eye, d, &hit) ? &high : &low) = middle;
  }
  return 0.5 * (low + high);
}

/* Distance along the ray to a place of the ground, as it is met, less the true one. */
static double compare_ground(const test_world *w, np_dvec3 eye, np_dvec3 place) {
  const np_dvec3 way = np_dvec3_subtract(place, eye);
  np_ground_hit hit;
  if (!np_world_intersect_ground(&w->world, eye, np_dvec3_to_float(np_dvec3_normalize(way)), &hit)) return 0.0;
  return hit.distance_m - np_dvec3_length(way);
}

/* The same of half of a cloud's opacity: it rises over a voxel above its top, of an extinction of 1/m, along a ray that
 * comes down by `slope`. */
static double compare_cloud(const test_world *w, np_dvec3 eye, np_dvec3 place) {
  const np_dvec3 way = np_dvec3_subtract(place, eye);
  const np_camera_ray ray = {.origin = eye, .direction = np_dvec3_to_float(np_dvec3_normalize(way))};
  const double slope = -(double)ray.direction.z, voxel_m = 25.0;
  const double half = sqrt(2.0 * voxel_m * log(2.0) / slope) - voxel_m / slope;
  return test_integrators(w->context)->half_distance(&w->world, &ray, INFINITY) - np_dvec3_length(way) - half;
}

/* Angles are those of float directions, 1.2e-7 rad. Hills are known to 6 mm (test_terrain), and by that angle over a
 * slope; half of a cloud to the 25 m of a voxel, which are sampled, and smoothly so. Offsets are over 1 + 1e-6 of the
 * altitude. */
static void geometry_follows_the_camera(void **state) {
  (void)state;
  test_world w;
  neph_terrain *terrain;
  start_planet(&w, &terrain);
  const int count = is_long ? 2000 : 32;
  const double ground = neph_terrain_get_elevation_m(terrain, 0.0, 3e3);
  const np_dvec3 peak = np_dvec3_make(0.0, 3e3, ground - 3e3 * 3e3 / (2.0 * planet_radius_m));
  double horizon_off = 0.0, ground_off = 0.0, cloud_off = 0.0, bend = 0.0, last[2] = {0.0};
  for (int i = 0; i < count; i++) {
    const double altitude = get_altitude(i, count);
    const np_dvec3 far_eye = np_dvec3_make(-100e3, 0.0, altitude - 100e3 * 100e3 / (2.0 * planet_radius_m));
    const double radius = planet_radius_m + np_altitude(far_eye, planet_radius_m);
    const double down = asin(fmin(planet_radius_m / radius, 1.0)), tilt = atan2(100e3, planet_radius_m + far_eye.z);
    const double horizon = search_horizon(&w, far_eye);
    horizon_off = fmax(horizon_off, fabs(horizon - (NP_PI - down + tilt)));
    const np_dvec3 eye = np_dvec3_make(0.0, 0.0, altitude + 2e3);
    ground_off = fmax(ground_off, fabs(compare_ground(&w, eye, peak)) / (1.0 + 1e-6 * altitude));
    const double cloud = compare_cloud(&w, eye, np_dvec3_make(0.0, 6e3, 1e3 + 25.0 * (TEST_EDGE - 1)));
    cloud_off = fmax(cloud_off, fabs(cloud) / (1.0 + 1e-6 * altitude));
    if (i > 1) bend = fmax(bend, fabs(cloud - 2.0 * last[1] + last[0]) / (1.0 + 1e-6 * altitude));
    last[0] = last[1];
    last[1] = cloud;
  }
  test_page_add_figure(&page, "\n## Places and sizes\n");
  test_page_add_figure(&page, "%d altitudes from %g m to %g km: the horizon is off by %.2g rad, hills by %.2g m,",
                       count, first_m, 1e-3 * last_m, horizon_off, ground_off);
  test_page_add_figure(&page, "the top of a cloud by %.2g m, of which from one altitude to the next changes %.2g m.\n",
                       cloud_off, bend);
  assert_true(horizon_off < 1.2e-7);
  assert_true(ground_off < 0.02);
  assert_true(cloud_off < 25.0);
  assert_true(bend < (is_long ? 0.1 : 2.0));
  neph_terrain_release(terrain);
  test_world_destroy(&w);
}

/* ---- Light ---- */

static const char planet_scene[] =
    "{camera: {kind: equirectangular, position: [0, 0, 1 km], look_at: [0, 10 km, 0], resolution: [32, 64]},"
    " sun: {elevation: 35 deg, azimuth: 120 deg},"
    " clouds: [{name: deck, bake: {preset: stratocumulus, extent: [6 km, 6 km], center: [0, 4 km], voxel: 200 m}}],"
    " terrain: {ridges: {samples: 65, relief: 300 m}, width: 24 km},"
    " render: {samples: 1, wavelengths: 3}, output: {color_space: bands}}";

enum { HALVES = 2 };

/* Means of the upper and of the lower half of all directions, in green. */
static void compute_means(const neph_image *image, double out[HALVES]) {
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  const float *values = neph_image_get_values(image, "G");
  double weights[HALVES] = {0.0};
  out[0] = out[1] = 0.0;
  for (unsigned y = 0; y < height; y++)
    for (unsigned x = 0; x < width; x++) {
      const double weight = sin(NP_PI * (y + 0.5) / height);
      assert_true(isfinite(values[y * width + x]) && values[y * width + x] >= 0.0f);
      out[y >= height / 2] += weight * (double)values[y * width + x];
      weights[y >= height / 2] += weight;
    }
  for (int half = 0; half < HALVES; half++) out[half] /= weights[half];
}

/* The light of either half of the sphere changes evenly with the logarithm of the altitude: second differences, over
 * its most. In 32 steps, of a factor of 1.5 each, the eye passes the deck in three: a tenth; in 2000, what single
 * samples of pixels leave. */
static void light_follows_the_camera(void **state) {
  (void)state;
  static test_log messages;
  test_log_start(&messages);
  neph_context *context = test_context_create(2, &messages);
  neph_scene *scene;
  neph_renderer *renderer;
  assert_int_equal(neph_scene_load_text(context, planet_scene, "scene.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_renderer_create(context, &renderer), NEPH_OK);
  const int count = is_long ? 2000 : 32;
  double last[3][HALVES], bend[HALVES] = {0.0}, most[HALVES] = {0.0};
  for (int i = 0; i < count; i++) {
    char position[80];
    neph_image *image;
    (void)snprintf(position, sizeof position, "[0, 0, %.6f]", get_altitude(i, count) + 400.0);
    assert_int_equal(neph_scene_set(scene, "camera.position", position), NEPH_OK);
    if (neph_renderer_render(renderer, scene, NULL, &image)) fail_msg("%s: %s", position, messages.text);
    compute_means(image, last[i % 3]);
    neph_image_destroy(image);
    for (int half = 0; half < HALVES; half++) {
      const double *now = &last[i % 3][half], *before = &last[(i + 2) % 3][half], *first = &last[(i + 1) % 3][half];
      most[half] = fmax(most[half], *now);
      if (i > 1) bend[half] = fmax(bend[half], fabs(*now - 2.0 * *before + *first));
    }
    test_log_clear(&messages);
  }
  neph_renderer_destroy(renderer);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  test_page_add_figure(&page,
                       "%d pictures of the climb: second differences of the light from above are %.2g of it, from "
                       "below %.2g.\n",
                       count, bend[0] / most[0], bend[1] / most[1]);
  for (int half = 0; half < HALVES; half++) assert_true(bend[half] < (is_long ? 0.02 : 0.1) * most[half]);
}

/* ---- Places and sizes ---- */

/* A picture of a lumpy ball of `size` metres at a place, in a vacuum, its extinction the less the larger it is. */
static neph_image *render_ball(neph_context *context, double size, double place_m, const char *integrator) {
  neph_scene *scene;
  neph_volume *volume;
  neph_image *image;
  char text[600];
  (void)snprintf(text, sizeof text,
                 "{camera: {position: [%.17g, %.17g, 0], look_at: [%.17g, 0, 0], fov: 30 deg, resolution: [24, 24]},"
                 " atmosphere: {preset: none}, environment: {planet: none, radiance: 0.1}, sun: {elevation: 30 deg},"
                 " render: {integrator: %s, samples: 4, wavelengths: 3}, output: {color_space: bands}}",
                 place_m, -2.0 * size, place_m, integrator);
  if (neph_scene_load_text(context, text, "scene.yaml", &scene)) fail_msg("%s is not read", text);
  const double step = size / TEST_EDGE;
  assert_int_equal(test_volume_create(context, test_lumpy_ball, TEST_EDGE, np_dvec3_make(step, step, step),
                                      np_dvec3_make(place_m, 0.0, 0.0), &volume),
                   NEPH_OK);
  neph_placement_desc placement = NEPH_PLACEMENT_DESC_DEFAULT;
  placement.density_value = 20.0 / size;
  assert_int_equal(neph_scene_add_volume(scene, volume, &placement, NULL), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_volume_release(volume);
  neph_scene_destroy(scene);
  return image;
}

/* Rms difference over the mean, and of the means. */
static void compare_balls(const neph_image *a, const neph_image *b, double *out_rms, double *out_bias) {
  const float *x = neph_image_get_values(a, "G"), *y = neph_image_get_values(b, "G");
  const size_t count = (size_t)neph_image_get_width(a) * neph_image_get_height(a);
  double squares = 0.0, sums[2] = {0.0};
  for (size_t i = 0; i < count; i++) {
    squares += pow((double)x[i] - (double)y[i], 2.0) / (double)count;
    sums[0] += (double)x[i] / (double)count;
    sums[1] += (double)y[i] / (double)count;
  }
  *out_rms = sqrt(squares) / sums[1];
  *out_bias = fabs(sums[0] / sums[1] - 1.0);
}

/* Places are doubles, and index space is reached in them: 1e6 m from the origin 1e-10 m is lost, of voxels of 1/24 m
 * 3e-9, less than the floats in a brick. So a march differs by 1e-5, but for the steps that such a loss lengthens by a
 * piece: a thousandth of the picture. Paths part for good where one collision falls otherwise: what is left is noise,
 * of 24·24·4 samples of a spread below 2, and no bias above four standard errors of both. */
static void a_picture_is_the_same_anywhere_and_at_any_size(void **state) {
  (void)state;
  static const double sizes_m[] = {1.0, 1.0, 1e6, 1e-2}, places_m[] = {1e6, -1e7, 0.0, 0.0};
  static const char *const names[] = {"1e6 m away", "1e7 m away", "1000 km across", "1 cm across"};
  neph_context *context = test_context_create(2, NULL);
  if (!is_long)
    test_page_add_fact(&page, "32 altitudes, 32 pictures of the climb, 8 of a cloud in other places and sizes.\n");
  test_page_add_figure(&page, "| the same picture | difference |\n| --- | --- |");
  for (int path = 0; path < 2; path++) {
    const char *integrator = path ? "path" : "march";
    neph_image *expected = render_ball(context, 1.0, 0.0, integrator);
    for (int n = 0; n < 4; n++) {
      neph_image *found = render_ball(context, sizes_m[n], places_m[n], integrator);
      double rms, bias;
      compare_balls(found, expected, &rms, &bias);
      test_page_add_figure(&page, "| a ball of cloud %s, %s | %.2g rms, %.2g bias |", names[n], integrator, rms, bias);
      assert_true(path ? bias < 4.0 * sqrt(2.0) * 2.0 / sqrt(24.0 * 24.0 * 4.0) : rms < 1e-3);
      neph_image_destroy(found);
    }
    neph_image_destroy(expected);
  }
  neph_context_destroy(context);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(geometry_follows_the_camera),
      cmocka_unit_test(light_follows_the_camera),
      cmocka_unit_test(a_picture_is_the_same_anywhere_and_at_any_size),
  };
  is_long = argc > 1 && strcmp(argv[1], "long") == 0;
  page = test_page_open(argc, argv);
  const int result = cmocka_run_group_tests(tests, NULL, NULL);
  test_page_close(&page);
  return result;
}
