/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of every kind of camera, in both integrators: uniform light, bokeh, clipping, tiles, air. */
#include <stdlib.h>

#include <nephos/nephos.h>

#include "atmosphere/sky_along.h"
#include "core/units.h"
#include "image/exposure.h"
#include "test_cumulus_scene.h"
#include "test_support.h"

static const char *const kinds[] = {"perspective", "orthographic", "equirectangular", "fisheye"};
static const char *const integrators[] = {"march", "path"};

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

typedef struct change {
  const char *key, *value;
} change;

/* A scene with keys changed, up to one without a name; of the crop alone, or NULL for all. */
static neph_image *render(test_fixture *f, const char *text, const change *changes, const unsigned crop[4]) {
  neph_scene *scene;
  neph_image *image;
  assert_int_equal(neph_scene_load_text(f->context, text, "test.yaml", &scene), NEPH_OK);
  for (; changes->key; changes++)
    if (neph_scene_set(scene, changes->key, changes->value)) fail_msg("%s: %s", changes->key, f->log.text);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  for (int a = 0; crop && a < 2; a++) {
    desc.crop_min[a] = crop[a];
    desc.crop_max[a] = crop[2 + a];
  }
  if (neph_render_image(scene, &desc, &image)) fail_msg("%s", f->log.text);
  neph_scene_destroy(scene);
  return image;
}

/* ---- Uniform light ---- */

/* Through any lens and projection a uniform environment is itself: a fisheye's corners are black, of alpha 0. 1e-6: a
 * sum of equal floats. */
static void a_uniform_environment_stays_uniform(void **state) {
  static const char text[] = "{camera: {position: [0, 0, 0], look_at: [0, 10, 3], f_stop: 1.4, blades: 5, fov: 40 deg,"
                             " focus_distance: 2 m, resolution: [16, 16]}, atmosphere: none,"
                             " environment: {radiance: 0.5, planet: none}, sun: {irradiance: 0}, render: {samples: 8},"
                             " output: {color_space: bands}}";
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 2; i++) {
      neph_image *image =
          render(*state, text,
                 (change[]){{"camera.kind", kinds[k]}, {"render.integrator", integrators[i]}, {NULL, NULL}}, NULL);
      const float *green = neph_image_get_channel(image, "G"), *alpha = neph_image_get_channel(image, "A");
      for (unsigned p = 0; p < 256; p++) {
        const double r = hypot(p % 16 + 0.5 - 8.0, p / 16 + 0.5 - 8.0);
        const bool is_outside = k == 3 && r > 10.0; /* a pixel's filter reaches √2 */
        if (k < 3 || r < 6.5 || is_outside) assert_near((double)green[p], is_outside ? 0.0 : 0.5, 1e-6);
        assert_near((double)alpha[p], 0.0, 0.0);
      }
      neph_image_destroy(image);
    }
}

/* ---- Bokeh ---- */

/* Light, middle and mean square from there, of a picture's green. */
typedef struct spot {
  double sum, x, y, square;
} spot;

static spot measure_spot(neph_image *image) {
  const unsigned width = neph_image_get_width(image), count = width * neph_image_get_height(image);
  const float *green = neph_image_get_channel(image, "G");
  spot s = {0};
  for (unsigned p = 0; p < count; p++) {
    s.sum += (double)green[p];
    s.x += (double)green[p] * (p % width + 0.5);
    s.y += (double)green[p] * (p / width + 0.5);
  }
  s.x /= s.sum;
  s.y /= s.sum;
  for (unsigned p = 0; p < count; p++)
    s.square += (double)green[p] * (pow(p % width + 0.5 - s.x, 2) + pow(p / width + 0.5 - s.y, 2)) / s.sum;
  return s;
}

/* The sun, a disk of diameter d pixels, blurs to its convolution with a disk of the diameter D of the thin lens, and
 * with the filter: mean squares D²/8, d²/8, two of the tent's 1/6, and a pixel's. D = A/F·W/(2·tan(fov/2)) is 13.9 by
 * f/0.02 of 51 mm, in focus at 12.5 m, over 48 pixels of 38.9°. 3 %: some 10⁴ samples meet the sun. */
static void the_sun_out_of_focus_is_the_aperture(void **state) {
  static const char text[] = "{camera: {position: [0, 0, 0], look_at: [0, 100, 0], focal_length: 51 mm, sensor: 36 mm,"
                             " f_stop: 0.02, focus_distance: 12.5 m, resolution: [48, 48]}, atmosphere: none,"
                             " environment: {planet: none}, render: {samples: 128}, output: {color_space: bands},"
                             " sun: {elevation: 0 deg, azimuth: 0 deg, angular_radius: 3 deg, limb_darkening: false}}";
  const double per_tangent = 48.0 * 51.0 / 36.0, blur = 0.051 / 0.02 / 12.5 * per_tangent;
  const double sun = 2.0 * tan(3.0 * NP_DEGREE) * per_tangent;
  const double shape[] = {blur * blur / 8.0, blur * blur / 4.0 * (1.0 / 3.0)}; /* disk; square, corners on its rim */
  const char *const blades[] = {"round", "4"};
  for (int i = 0; i < 2; i++)
    for (int b = 0; b < 2; b++) {
      neph_image *image =
          render(*state, text,
                 (change[]){{"render.integrator", integrators[i]}, {"camera.blades", blades[b]}, {NULL, NULL}}, NULL);
      const spot s = measure_spot(image);
      assert_near(s.x, 24.0, 0.1);
      assert_near(s.y, 24.0, 0.1);
      assert_near_relative(s.square, shape[b] + sun * sun / 8.0 + 2.0 / 6.0, 0.03);
      /* The sun's irradiance, in a pinhole's pixels near the middle. */
      assert_near_relative(s.sum / (per_tangent * per_tangent), 1.8504, 0.03);
      neph_image_destroy(image);
    }
}

/* ---- Clipping ---- */

static const char cumulus[] = TEST_CUMULUS_SCENE "render: {samples: 2, multiple_scattering: octaves}\n"
                                                 "output: {aovs: [distance, mean_distance]}\n";

static double sum_channel(neph_image *image, const char *name) {
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  const float *values = neph_image_get_channel(image, name);
  double sum = 0.0;
  for (size_t p = 0; p < count; p++) sum += (double)values[p];
  return sum;
}

/* Nothing is seen past both planes, all between wide ones, and what is seen lies between. */
static void clipping_hides_what_is_outside(void **state) {
  for (int i = 0; i < 2; i++) {
    const change how = {"render.integrator", integrators[i]}, end = {NULL, NULL}, dark = {"atmosphere", "none"};
    neph_image *whole = render(*state, cumulus, (change[]){how, dark, end}, NULL);
    neph_image *near = render(*state, cumulus, (change[]){how, dark, {"camera.near", "500 km"}, end}, NULL);
    neph_image *far = render(*state, cumulus, (change[]){how, dark, {"camera.far", "10 m"}, end}, NULL);
    neph_image *part =
        render(*state, cumulus, (change[]){how, dark, {"camera.near", "2900 m"}, {"camera.far", "6 km"}, end}, NULL);
    assert_near(sum_channel(near, "A"), 0.0, 0.0);
    assert_near(sum_channel(far, "A"), 0.0, 0.0);
    const double some = sum_channel(part, "A");
    assert_true(some > 1.0 && some < sum_channel(whole, "A") - 1.0);
    const float *depth = neph_image_get_channel(part, "Z"), *mean = neph_image_get_channel(part, "mean_distance");
    for (unsigned p = 0; p < 24 * 16; p++) {
      if (!isinf(depth[p])) assert_true(depth[p] >= 2900.0f && depth[p] <= 6001.0f);
      if (!isinf(mean[p])) assert_true(mean[p] >= 2900.0f && mean[p] <= 7400.0f); /* 6 km along a corner's ray */
    }
    neph_image *const images[] = {whole, near, far, part};
    for (int n = 0; n < 4; n++) neph_image_destroy(images[n]);
  }
}

/* ---- Tiles ---- */

static void assert_part(neph_image *whole, neph_image *part, const unsigned crop[4]) {
  const unsigned width = neph_image_get_width(part), stride = neph_image_get_width(whole);
  for (unsigned c = 0; c < neph_image_get_channel_count(whole); c++) {
    const char *name = neph_image_get_channel_name(whole, c);
    const float *a = neph_image_get_channel(whole, name), *b = neph_image_get_channel(part, name);
    for (unsigned y = 0; y < neph_image_get_height(part); y++)
      assert_memory_equal(a + (crop[1] + y) * stride + crop[0], b + y * width, width * sizeof *a);
  }
}

/* Covers shadows in the air, whose rays depend on the whole picture; light falls, and is never negative. */
static void parts_have_the_bits_of_the_whole(void **state) {
  static const unsigned crop[4] = {0, 5, 9, 16};
  for (int k = 1; k < 4; k++)
    for (int i = 0; i < 2; i++) {
      const change changes[] = {{"camera.kind", kinds[k]},
                                {"render.integrator", integrators[i]},
                                {"render.air_shadows", "true"},
                                {"camera.f_stop", "2"},
                                {NULL, NULL}};
      neph_image *whole = render(*state, cumulus, changes, NULL), *part = render(*state, cumulus, changes, crop);
      assert_part(whole, part, crop);
      assert_true(sum_channel(whole, "G") > 1.0 && sum_channel(whole, "A") > 1.0);
      neph_image_destroy(whole);
      neph_image_destroy(part);
    }
}

/* ---- Air ---- */

/* Panoramas see the sky that a perspective sees: 1 % for half a pixel of gradient. */
static void panoramas_see_the_same_sky(void **state) {
  static const char text[] =
      "{camera: {position: [0, 0, 500], look_at: [0, 1000, 800], fov: 0.5 deg, resolution: [1, 1]},"
      " sun: {elevation: 40 deg, azimuth: 120 deg}}";
  const change end = {NULL, NULL};
  neph_image *flat = render(*state, text, &end, NULL);
  const unsigned row = (unsigned)((0.5 - atan(0.3) / NP_PI) * 360.0), crop[4] = {359, row, 361, row + 1};
  neph_image *sphere = render(
      *state, text, (change[]){{"camera.kind", "equirectangular"}, {"camera.resolution", "[720, 360]"}, end}, crop);
  const change fisheye[] = {
      {"camera.kind", "fisheye"}, {"camera.resolution", "[45, 45]"}, {"render.samples", "16"}, end};
  neph_image *round = render(*state, text, fisheye, NULL);
  for (int c = 0; c < 3; c++) {
    const char *const name = ((const char *const[]){"R", "G", "B"})[c];
    const double expected = (double)neph_image_get_channel(flat, name)[0];
    const float *over = neph_image_get_channel(sphere, name);
    assert_near_relative(0.5 * ((double)over[0] + (double)over[1]), expected, 0.01);
    assert_near_relative((double)neph_image_get_channel(round, name)[22 * 45 + 22], expected, 0.01);
  }
  neph_image_destroy(flat);
  neph_image_destroy(sphere);
  neph_image_destroy(round);
}

/* Air traced along a ray is the tables' own, within twice their tolerance of 0.7 %, from the observer; and it does not
 * mind another observer, within that of the other's gather. */
static void traced_air_is_that_of_the_tables(void **state) {
  test_fixture *f = *state;
  neph_atmosphere *air;
  neph_sky *skies[2];
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  desc.sun_direction[0] = cos(0.6), desc.sun_direction[2] = sin(0.6);
  desc.observer_m[2] = 500.0;
  assert_int_equal(neph_atmosphere_create(f->context, NULL, &air), NEPH_OK);
  assert_int_equal(neph_sky_create(air, &desc, &skies[0]), NEPH_OK);
  desc.observer_m[2] = 9000.0;
  assert_int_equal(neph_sky_create(air, &desc, &skies[1]), NEPH_OK);
  const double slopes[] = {-0.5, 0.05, 0.4, 2.0}, distances[] = {800.0, 2e4, INFINITY};
  for (int s = 0; s < 4; s++)
    for (int d = 0; d < 3; d++) {
      const np_vec3 direction = np_vec3_normalize(np_vec3_make(0.3f, 1.0f, (float)slopes[s]));
      const double end = s == 0 ? fmin(distances[d], 900.0) : distances[d];
      const np_aerial_perspective table = np_sky_aerial_perspective(skies[0], direction, end);
      const np_dvec3 origin = np_dvec3_make(0, 0, 500);
      for (int k = 0; k < 2; k++) {
        const np_aerial_perspective traced = np_sky_trace_air(skies[k], origin, direction, end);
        for (int b = 0; b < 3; b++) {
          assert_near_relative((double)traced.inscatter.band[b], (double)table.inscatter.band[b], 0.015);
          assert_near((double)traced.transmittance.band[b], (double)table.transmittance.band[b], 0.005);
        }
      }
    }
  neph_sky_destroy(skies[0]);
  neph_sky_destroy(skies[1]);
  neph_atmosphere_release(air);
}

/* Seen from the side, the air of parallel rays thins with height: each ray has its own altitude. 6 %: three standard
 * errors of 8192 paths. */
static void parallel_rays_see_air_of_their_height(void **state) {
  static const char text[] = "{camera: {kind: orthographic, orthographic_width: 5 km, position: [0, 0, 12 km],"
                             " look_at: [0, 100 km, 12 km], resolution: [1, 4]}, render: {samples: 256},"
                             " sun: {elevation: 40 deg, azimuth: 120 deg}}";
  const change none[] = {{NULL, NULL}},
               traced[] = {{"render.integrator", "path"}, {"render.samples", "8192"}, {NULL, NULL}};
  neph_image *tables = render(*state, text, none, NULL), *paths = render(*state, text, traced, NULL);
  for (int c = 0; c < 3; c++) {
    const char *const name = ((const char *const[]){"R", "G", "B"})[c];
    const float *a = neph_image_get_channel(tables, name), *b = neph_image_get_channel(paths, name);
    assert_true(a[0] < (c == 0 ? 0.5f : 0.9f) * a[3]);
    for (int p = 0; p < 4; p++) assert_near_relative((double)a[p], (double)b[p], 0.06);
  }
  neph_image_destroy(tables);
  neph_image_destroy(paths);
}

/* ---- Stars, header ---- */

/* The stars' light is the same in focus and out of it, to the part of a disk that leaves the picture. */
static void stars_out_of_focus_keep_their_light(void **state) {
  static const char text[] = "{place: {latitude: 45 deg, longitude: 0 deg}, atmosphere: none, sun: {irradiance: 0},"
                             " camera: {position: [0, 0, 10], look_at: [0, 10, 20], fov: 60 deg, resolution: [96, 96]},"
                             " environment: {planet: none}, stars: {sidereal_time: 100 deg}, render: {samples: 1}}";
  const change end = {NULL, NULL};
  neph_image *sharp = render(*state, text, &end, NULL);
  neph_image *soft =
      render(*state, text, (change[]){{"camera.f_stop", "0.01"}, {"camera.focus_distance", "50 m"}, end}, NULL);
  const double all = sum_channel(sharp, "G");
  assert_true(all > 0.0);
  assert_near_relative(sum_channel(soft, "G"), all, 0.1); /* disks of 5 pixels on 96 */
  double sharpest = 0.0, softest = 0.0;
  for (unsigned p = 0; p < 96 * 96; p++) {
    sharpest = fmax(sharpest, (double)neph_image_get_channel(sharp, "G")[p]);
    softest = fmax(softest, (double)neph_image_get_channel(soft, "G")[p]);
  }
  assert_true(softest < 0.5 * sharpest);
  neph_image_destroy(sharp);
  neph_image_destroy(soft);
}

/* 1.2·2^EV cd/m² come to 1 (ISO 12232): a light of which the meter says how many of them a value
 * is. */
static void a_preview_may_be_exposed_by_the_camera(void **state) {
  test_fixture *f = *state;
  neph_image *image = render(f,
                             "{camera: {resolution: [2, 1], f_stop: 4, shutter: 0.0625 s, iso: 100}, atmosphere: none,"
                             " environment: {radiance: 1, planet: none}, sun: {irradiance: 0}, render: {samples: 1}}",
                             (change[]){{NULL, NULL}}, NULL);
  assert_int_equal(neph_image_set_attribute(image, "nephos:meter", "0.5"), NEPH_OK);
  assert_int_equal(neph_image_set_attribute(image, "nephos:meterLuminance", "76.8"), NEPH_OK);
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.exposure = NEPH_EXPOSURE_CAMERA;
  double factor;
  assert_int_equal(np_exposure_choose(image, &desc, &factor), NEPH_OK);
  assert_near_relative(factor, 76.8 / 0.5 / (1.2 * 256.0), 1e-9);
  neph_image_destroy(image);
  neph_scene *scene;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_load_text(f->context, "{output: {exposure: camera}}", "test.yaml", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "output.exposure is camera, must come with camera.f_stop, shutter and iso", "");
}

static void the_header_says_what_was_used(void **state) {
  neph_image *image = render(*state,
                             "{camera: {resolution: [2, 1], f_stop: 16, shutter: 0.0078125 s, iso: 100,"
                             " stereo: {eye: right}}, atmosphere: none, render: {samples: 1}}",
                             (change[]){{NULL, NULL}}, NULL);
  assert_string_equal(neph_image_get_attribute(image, "view"), "right");
  assert_string_equal(neph_image_get_attribute(image, "nephos:EV100"), "15");
  assert_string_equal(neph_image_get_attribute(image, "aperture"), "16");
  assert_string_equal(neph_image_get_attribute(image, "isoSpeed"), "100");
  assert_non_null(neph_image_get_attribute(image, "expTime"));
  assert_non_null(neph_image_get_attribute(image, "focus"));
  neph_image_destroy(image);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_uniform_environment_stays_uniform, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_sun_out_of_focus_is_the_aperture, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(clipping_hides_what_is_outside, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(parts_have_the_bits_of_the_whole, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(panoramas_see_the_same_sky, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(traced_air_is_that_of_the_tables, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(parallel_rays_see_air_of_their_height, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(stars_out_of_focus_keep_their_light, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_preview_may_be_exposed_by_the_camera, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_header_says_what_was_used, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
