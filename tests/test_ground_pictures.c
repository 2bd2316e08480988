/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of ground that is not even, by both integrators: albedo, rock, snow, water and the edges of shadows. */
#include <stdlib.h>

#include <nephos/nephos.h>

#include "optics/water.h"
#include "test_support.h"
#include "test_world.h"

static neph_image *render(neph_context *context, const char *text, const char *integrator) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static double compute_mean(neph_image *image, const char *channel) {
  const unsigned count = neph_image_get_width(image) * neph_image_get_height(image);
  double sum = 0.0;
  for (unsigned i = 0; i < count; i++) sum += (double)neph_image_get_channel(image, channel)[i] / count;
  return sum;
}

static const char *const integrators[2] = {"march", "path"};

/* ---- Land ---- */

enum { SQUARES = 4 };

static void save_checkerboard(neph_context *context, const char *path) {
  static const char *const names[3] = {"R", "G", "B"};
  enum { SIDE = 64 };
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(context, SIDE, SIDE, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < SIDE * SIDE; i++)
      neph_image_get_channel(image, names[c])[i] = (i % SIDE / 16 + i / SIDE / 16) % 2 ? 0.1f : 0.6f;
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_HALF), NEPH_OK);
  neph_image_destroy(image);
}

/* Under an even sky of radiance 1 each square is as bright as its albedo. A picture of 16² over 4 km, seen from
 * straight above; the four pixels about squares' middles. Russian roulette ends most paths from ground of 0.1, which
 * leaves a standard error of 2.5 % after 4 × 625 samples: four times that. */
static void squares_are_seen_by_both_integrators(void **state) {
  test_fixture *f = *state;
  char path[4096], text[8192];
  (void)snprintf(path, sizeof path, "%s/board.exr", f->folder);
  save_checkerboard(f->context, path);
  (void)snprintf(text, sizeof text,
                 "camera: {position: [0 m, 0 m, 10 km], look_at: [0 m, 1 mm, 0 m], fov: 22.6199 deg,\n"
                 "  resolution: [16, 16]}\n"
                 "sun: {irradiance: 0}\n"
                 "atmosphere: none\n"
                 "environment: {radiance: 1}\n"
                 "terrain: {ridges: {relief: 0 m, samples: 65}, width: 4 km, albedo_image: \"%s\"}\n"
                 "render: {samples: 625}\n"
                 "output: {pixel_type: float, color_space: bands}\n",
                 path);
  for (int k = 0; k < 2; k++) {
    neph_image *image = render(f->context, text, integrators[k]);
    const float *green = neph_image_get_channel(image, "G");
    for (int row = 0; row < SQUARES; row++)
      for (int column = 0; column < SQUARES; column++) {
        double mean = 0.0;
        for (int i = 0; i < 4; i++) mean += 0.25 * (double)green[16 * (4 * row + 1 + i / 2) + 4 * column + 1 + i % 2];
        assert_near_relative(mean, (row + column) % 2 ? 0.1 : 0.6, k ? 0.1 : 0.01);
      }
    neph_image_destroy(image);
  }
}

/* Under the same sky both integrators see mountains of rock and snow alike: light from slope to slope, which the march
 * leaves out, is a twentieth at most with these albedos and slopes. Snow brightens what is high. */
static void rock_and_snow_are_seen_by_both_integrators(void **state) {
  test_fixture *f = *state;
  static const char text[] =
      "camera: {position: [0 m, -6 km, 6 km], look_at: [0 m, 0 m, 0 m], fov: 40 deg, resolution: [32, 18]}\n"
      "sun: {irradiance: 0}\n"
      "atmosphere: none\n"
      "environment: {radiance: 1}\n"
      "terrain: {ridges: {relief: 1500 m, samples: 257}, width: 20 km, albedo: 0.1, rock: {slope: 25 deg},\n"
      "  snow: {level: 700 m}}\n"
      "render: {samples: 64}\n"
      "output: {pixel_type: float, color_space: bands}\n";
  double mean[2];
  for (int k = 0; k < 2; k++) {
    neph_image *image = render(f->context, text, integrators[k]);
    const float *green = neph_image_get_channel(image, "G");
    float low = 1.0f, high = 0.0f;
    for (int i = 0; i < 32 * 18; i++) low = fminf(low, green[i]), high = fmaxf(high, green[i]);
    assert_true(low < 0.14f && high > 0.6f);
    mean[k] = compute_mean(image, "G");
    neph_image_destroy(image);
  }
  print_message("rock and snow: march %.4f, path %.4f\n", mean[0], mean[1]);
  assert_near_relative(mean[0], mean[1], 0.05);
}

/* ---- Water ---- */

static const char sea[] =
    "camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 1 km, %s], fov: 4 deg, resolution: [4, 4]}\n"
    "sun: {elevation: 40 deg, azimuth: 0 deg, irradiance: %s}\n"
    "atmosphere: none\n"
    "environment: {radiance: 1}\n"
    "water: {wind: 5 m/s, albedo: 0.3}\n"
    "render: {samples: %d}\n"
    "output: {pixel_type: float, color_space: bands}\n";

/* Under an even sky of radiance 1 water sends back R + albedo·T, and so do both integrators: at 45° and at 3° below the
 * horizon. R is known to 0.005. Paths that the planet's curve lets see the sea again lose nothing that counts. */
static void even_sky_over_water(void **state) {
  test_fixture *f = *state;
  static const char *const targets[2] = {"-500 m", "447.6 m"};
  static const double cosines[2] = {0.7071, 0.0523};
  const np_water water = np_water_make(0.0, 5.0, np_spectrum_grey(0.3f));
  for (int at = 0; at < 2; at++)
    for (int k = 0; k < 2; k++) {
      char text[2048];
      (void)snprintf(text, sizeof text, sea, targets[at], "0", 256);
      neph_image *image = render(f->context, text, integrators[k]);
      const double reflected = (double)np_water_reflectance(&water, (float)cosines[at]);
      const double mean = compute_mean(image, "G");
      print_message("%s at cosine %.3f: %.4f, R %.4f\n", integrators[k], cosines[at], mean, reflected);
      assert_near(mean, reflected + 0.3 * (1.0 - reflected), 0.012);
      neph_image_destroy(image);
    }
}

/* The sun's glint in the mirror direction: the same in both, within the standard error of 1 % that 4096 samples of
 * the path leave, three times. */
static void glint_is_the_same_in_both_integrators(void **state) {
  test_fixture *f = *state;
  double mean[2];
  for (int k = 0; k < 2; k++) {
    char text[2048];
    (void)snprintf(text, sizeof text, sea, "-339 m", "10", 256);
    neph_image *image = render(f->context, text, integrators[k]);
    mean[k] = compute_mean(image, "G");
    neph_image_destroy(image);
  }
  print_message("glint: march %.4f, path %.4f\n", mean[0], mean[1]);
  assert_true(mean[1] > 2.0);
  assert_near_relative(mean[0], mean[1], 0.03);
}

/* A sea under clouds, sky and sun, with an island: clouds, sky and land are mirrored. The march's molecules take the
 * sea for Lambert's, and its reflection has no shadows in the air: 0.7 % of red and blue here, where the path's noise
 * is some 0.5 %. */
static void march_is_near_the_path_over_a_sea(void **state) {
  test_fixture *f = *state;
  static const char text[] =
      "camera: {position: [0 m, -4 km, 300 m], look_at: [0 m, 0 m, -350 m], fov: 30 deg, resolution: [12, 8]}\n"
      "sun: {elevation: 30 deg, azimuth: 110 deg}\n"
      "clouds:\n"
      "  - name: cumulus\n"
      "    bake: {preset: cumulus_mediocris, seed: 4, extent: [3 km, 3 km], base: 900 m, voxel: 100 m, coverage: 0.6,\n"
      "      cell: 1800 m, type: 0.6, billow: 430 m, billowiness: 0.5, erosion: 0.7, wispiness: 0.3, turbulence: 0.3}\n"
      "terrain: {ridges: {samples: 65, relief: 300 m}, width: 3 km}\n"
      "water: {level: 60 m}\n"
      "render: {samples: 512}\n"
      "output: {pixel_type: float, color_space: bands}\n";
  static const char *const channels[3] = {"R", "G", "B"};
  neph_image *march = render(f->context, text, "march"), *path = render(f->context, text, "path");
  for (int c = 0; c < 3; c++) {
    const double a = compute_mean(march, channels[c]), b = compute_mean(path, channels[c]);
    print_message("sea, %s: march %.5f, path %.5f, %+.2f %%\n", channels[c], a, b, 100.0 * (a / b - 1.0));
    assert_near_relative(a, b, 0.03);
  }
  neph_image_destroy(march);
  neph_image_destroy(path);
}

/* Hazy sky over a rough sea, low opposite the sun and below it: haze scatters the glint on, away from the sun. Ground
 * that reflects as much evenly makes the first 7 % brighter and the second 6 % darker (red). The path's noise is 1 %.
 */
static void haze_has_the_glint(void **state) {
  test_fixture *f = *state;
  static const char text[] =
      "camera: {position: [0 m, 0 m, 3 m], look_at: [0 m, %s1 km, 100 m], fov: 60 deg, resolution: [12, 2]}\n"
      "sun: {elevation: 28.5 deg, azimuth: 180 deg}\n"
      "atmosphere: earth-hazy\n"
      "water: {wind: 14.9 m/s}\n"
      "render: {samples: 4096}\n"
      "output: {pixel_type: float, color_space: bands}\n";
  static const char *const sides[2] = {"", "-"};
  for (int side = 0; side < 2; side++) {
    double red[2];
    char filled[1024];
    (void)snprintf(filled, sizeof filled, text, sides[side]);
    for (int k = 0; k < 2; k++) {
      neph_image *image = render(f->context, filled, integrators[k]);
      red[k] = compute_mean(image, "R");
      neph_image_destroy(image);
    }
    print_message("%s the sun: march %.5f, path %.5f, %+.2f %%\n", side ? "below" : "opposite", red[0], red[1],
                  100.0 * (red[0] / red[1] - 1.0));
    assert_near_relative(red[0], red[1], 0.04);
  }
}

/* The waves' glint on the underside of a deck, without air: march and path with water and without a planet. Water of
 * Lambert's kind would give a third of the light that waves give here, seven tenths of the picture. The path's noise in
 * the difference is 2 %; means over the solid angle of low ordinates make it 19 % more in the march, and means weighed
 * by the cosine to the face, which keep the flux, 14 % less, and decks and fog elsewhere up to 3 % darker than paths.
 */
static void glint_lights_clouds_from_below(void **state) {
  test_fixture *f = *state;
  static const char text[] =
      "camera: {position: [3 km, -4.5 km, 300 m], look_at: [0 m, 0 m, 1100 m], fov: 20 deg, resolution: [12, 6]}\n"
      "sun: {elevation: 12 deg, azimuth: 325 deg}\n"
      "atmosphere: none\n"
      "clouds: [{bake: {preset: stratocumulus, seed: 4, extent: 4 km, voxel: 80 m, base: 1 km}}]\n"
      "%s\n"
      "render: {samples: %d}\n"
      "output: {pixel_type: float, color_space: bands}\n";
  static const char *const below[2] = {"water: {wind: 4 m/s}", "environment: {planet: none}"};
  double water[2];
  for (int k = 0; k < 2; k++) {
    double mean[2];
    for (int n = 0; n < 2; n++) {
      char filled[2048];
      (void)snprintf(filled, sizeof filled, text, below[n], k ? 2048 : 64);
      neph_image *image = render(f->context, filled, integrators[k]);
      mean[n] = compute_mean(image, "G");
      neph_image_destroy(image);
    }
    water[k] = mean[0] - mean[1];
    print_message("%s: %.4f of it by the water %.4f\n", integrators[k], mean[0], water[k]);
  }
  assert_near_relative(water[0], water[1], 0.22);
}

/* ---- Shadow edges ---- */

/* Share of a disk's light past a straight edge that lies `x` of its radius from its middle. */
static double compute_disk_share(double x) {
  x = np_clamp(x, -1.0, 1.0);
  return 0.5 + (x * sqrt(1.0 - x * x) + asin(x)) / NP_PI;
}

/* The edge of a block 100 km up, of 23 voxels of 200 m, under a sun of 0.5° radius at the zenith: half a shadow is
 * H·tan r = 873 m wide. The block's outermost voxel fades over its 200 m, of which 10 m are transparent. 1024 samples
 * of the disk leave 1.6 %; four times that, and a voxel's 5 %. */
static void shadows_are_as_soft_as_the_sun_is_wide(void **state) {
  (void)state;
  test_world w;
  test_cloud cloud = test_cloud_make(test_full, 0.5f, np_phase_isotropic());
  cloud.step_m = np_dvec3_make(200.0, 200.0, 200.0);
  cloud.middle_m = np_dvec3_make(0.0, 0.0, 100e3 + 2300.0);
  test_world_create(&w, 1, cloud);
  w.world.has_planet = true;
  w.world.planet_radius_m = 1e8;
  w.world.ground_albedo = np_spectrum_grey(1.0f);
  w.world.sun_angular_radius_rad = (float)(0.5 * NP_DEGREE);
  w.world.sun_irradiance = np_spectrum_grey(NP_PI_F);
  const double half = 100e3 * tan(0.5 * NP_DEGREE);
  for (double x = -0.9; x <= 1.2; x += 0.3) {
    enum { SAMPLES = 1024 };
    double sums[2] = {0.0, 0.0};
    for (int k = 0; k < 2; k++) {
      np_random random = np_random_start(7, 0, 0, 0, (uint32_t)k);
      for (int n = 0; n < SAMPLES; n++) {
        np_integrator_sample sample;
        const np_camera_ray ray = {.origin = {2500.0 + x * half, 0.0, 100.0}, .direction = {0, 0, -1}};
        (k ? test_world_path : test_world_march)(&w, &ray, &random, &sample);
        sums[k] += test_sum_components(&sample, 1) / SAMPLES;
      }
    }
    assert_near(sums[0], compute_disk_share(x), 0.06);
    assert_near(sums[1], compute_disk_share(x), 0.06);
  }
  test_world_destroy(&w);
}

static int set_up_files(void **state) { return test_set_up(state, 2, NULL); }

#define FILES(name) cmocka_unit_test_setup_teardown(name, set_up_files, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      FILES(squares_are_seen_by_both_integrators),
      FILES(rock_and_snow_are_seen_by_both_integrators),
      FILES(even_sky_over_water),
      FILES(glint_is_the_same_in_both_integrators),
      FILES(march_is_near_the_path_over_a_sea),
      FILES(haze_has_the_glint),
      FILES(glint_lights_clouds_from_below),
      cmocka_unit_test(shadows_are_as_soft_as_the_sun_is_wide),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
