/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of more than three wavelengths: packets that add up, in one colour, with one error; the same bits however
 * the work is divided; what the header says of it. */
#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/context_private.h"
#include "stages/assembly.h"
#include "test_render_once.h"
#include "test_support.h"

/* A puff of a baked cloud that fills the view, in the air or without it. */
static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, -800 m, 500 m], look_at: [0 m, 0 m, 500 m], fov: 60 deg, resolution: [12, 8]}\n"
    "sun: {elevation: 20 deg, azimuth: 150 deg}\n"
    "clouds:\n"
    "  - {name: puff, bake: {preset: cumulus_humilis, model: cells, seed: 3, extent: [600 m, 600 m], base: 200 m,\n"
    "                        thickness: 600 m, voxel: 50 m, coverage: 1, extinction: 0.01 1/m}}\n"
    "render: {samples: 4, wavelengths: 6}\n"
    "output: {scale: 1, aovs: [background, terrain, air, sun, sky, ground, multiple, transmittance, standard_error]}\n";

typedef struct setting {
  const char *key, *value;
} setting;

static neph_scene *load(neph_context *context, const setting *settings, size_t count) {
  neph_scene *scene = NULL;
  assert_int_equal(neph_scene_load_text(context, scene_text, "test.yaml", &scene), NEPH_OK);
  for (size_t i = 0; i < count; i++)
    assert_int_equal(neph_scene_set(scene, settings[i].key, settings[i].value), NEPH_OK);
  return scene;
}

static neph_image *render(unsigned threads, const setting *settings, size_t count) {
  neph_context *context = test_context_create(threads, NULL);
  neph_scene *scene = load(context, settings, count);
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return image;
}

static size_t count_pixels(const neph_image *image) {
  return (size_t)neph_image_get_width(image) * neph_image_get_height(image);
}

static void threads_change_no_bit(void **state) {
  (void)state;
  for (unsigned i = 0; i < 2; i++) {
    const setting path = {"render.integrator", i ? "path" : "march"};
    neph_image *one = render(1, &path, 1), *three = render(3, &path, 1);
    for (unsigned c = 0; c < neph_image_get_channel_count(one); c++) {
      const char *name = neph_image_get_channel_name(one, c);
      assert_memory_equal(neph_image_get_channel(one, name), neph_image_get_channel(three, name),
                          count_pixels(one) * sizeof(float));
    }
    neph_image_destroy(one);
    neph_image_destroy(three);
  }
}

/* Sums of floats; some components are negative outside the gamut. */
static void assert_adds_up(const setting *settings, size_t setting_count) {
  static const char *const layers[] = {"background", "terrain", "air", "sun", "sky", "ground", "multiple"};
  neph_image *image = render(2, settings, setting_count);
  for (int c = 0; c < 3; c++) {
    const char name[2] = {"RGB"[c], '\0'};
    const float *beauty = neph_image_get_channel(image, name);
    for (size_t p = 0; p < count_pixels(image); p++) {
      double sum = 0, magnitude = 0;
      for (int l = 0; l < 7; l++) {
        char layer[32];
        (void)snprintf(layer, sizeof layer, "%s.%s", layers[l], name);
        const double value = (double)neph_image_get_channel(image, layer)[p];
        sum += value;
        magnitude += fabs(value);
      }
      assert_near((double)beauty[p], sum, 1e-5 * magnitude);
    }
  }
  neph_image_destroy(image);
}

static void components_add_up_to_the_beauty(void **state) {
  (void)state;
  static const setting three[] = {{"render.wavelengths", "3"}, {"render.integrator", "path"}};
  assert_adds_up(NULL, 0);
  assert_adds_up(three, 1);
  assert_adds_up(three, 2);
}

/* Without air, light is the sun's in every band but for a factor, the same paths are taken, and the relative error of
 * every colour is that of a single band. Had the packets' errors been added as if they were independent, it would be
 * less by √6. The albedo is the same in all bands; 1e-3 is float rounding of small differences. */
static void errors_of_packets_add_before_they_are_squared(void **state) {
  (void)state;
  static const setting base[] = {{"atmosphere", "none"}, {"environment.planet", "none"}, {"render.integrator", "path"}};
  static const setting bands[] = {{"atmosphere", "none"},
                                  {"environment.planet", "none"},
                                  {"render.integrator", "path"},
                                  {"render.wavelengths", "3"},
                                  {"output.color_space", "bands"}};
  neph_image *six = render(2, base, 3), *three = render(2, bands, 5);
  int lit = 0;
  for (int c = 0; c < 3; c++) {
    char name[2] = {"RGB"[c], '\0'}, error_name[32];
    (void)snprintf(error_name, sizeof error_name, "standard_error.%s", name);
    const float *a = neph_image_get_channel(six, name), *e = neph_image_get_channel(six, error_name);
    const float *b = neph_image_get_channel(three, name), *f = neph_image_get_channel(three, error_name);
    for (size_t p = 0; p < count_pixels(six); p++) {
      if (!(b[p] > 0.0f)) continue;
      lit++;
      assert_near_relative((double)(e[p] / a[p]), (double)(f[p] / b[p]), 1e-3);
    }
  }
  assert_true(lit > 100);
  neph_image_destroy(six);
  neph_image_destroy(three);
}

/* A cloud that absorbs nothing under even light is invisible, in the colour of a flat spectrum: x = y = 1/3 of
 * luminance 1, whose Rec.709 is (1.2048, 0.9483, 0.9089). The tolerance is the matching functions' interpolation. */
static void a_furnace_has_the_colour_of_its_light(void **state) {
  (void)state;
  static const double flat[3] = {1.2048, 0.9483, 0.9089};
  static const setting furnace[] = {{"atmosphere", "none"},      {"environment.planet", "none"},
                                    {"sun.irradiance", "0"},     {"environment.radiance", "1"},
                                    {"clouds[0].albedo", "1"},   {"render.integrator", "path"},
                                    {"render.wavelengths", "15"}};
  neph_image *image = render(2, furnace, sizeof furnace / sizeof *furnace);
  for (int c = 0; c < 3; c++) {
    const char name[2] = {"RGB"[c], '\0'};
    const float *plane = neph_image_get_channel(image, name);
    for (size_t p = 0; p < count_pixels(image); p++) assert_near((double)plane[p], flat[c], 4e-4);
  }
  neph_image_destroy(image);
}

/* ---- The sky ---- */

/* The radiance of the zenith in each packet, summed by hand over wavelengths. */
static void compute_zenith(neph_scene *scene, double out_rgb[3]) {
  np_plan plan;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  np_assembly assembly;
  np_monitor monitor;
  np_wavelengths wavelengths;
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  assert_int_equal(np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = false}, &plan), NEPH_OK);
  assert_int_equal(np_assembly_build(scene, &plan, &job, &monitor, &assembly), NEPH_OK);
  assert_int_equal(assembly.packet_count, 5);
  np_wavelengths_choose(15, &wavelengths);
  for (int c = 0; c < 3; c++) out_rgb[c] = 0.0;
  for (unsigned p = 0; p < 5; p++) {
    const np_packet *packet = &assembly.packets[p];
    const np_world *world = &packet->lights[0].world;
    const np_spectrum radiance =
        np_world_sky_radiance(world, world->camera_sky, assembly.camera.origin, np_vec3_make(0.0f, 0.0f, 1.0f));
    for (unsigned b = 0; b < 3; b++) {
      double rgb[3];
      const unsigned i = np_band_set_get_index(&wavelengths, p, b);
      assert_near(wavelengths.nm[i], packet->bands.nm[b], 0.0);
      np_color_space_weigh(NP_COLOR_REC709, wavelengths.xyz_nm[i], rgb);
      for (int c = 0; c < 3; c++) out_rgb[c] += rgb[c] * (double)radiance.band[b];
    }
  }
  np_assembly_clear(&assembly);
  np_plan_clear(&plan);
  np_stores_clear(scene->context, &stores);
}

/* The picture's top row lies a quarter of a degree off the zenith, where the sky differs by less than 1 %. */
static void the_sky_is_the_sum_of_its_packets(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  static const setting fifteen = {"render.wavelengths", "15"};
  neph_scene *scene = load(context, &fifteen, 1);
  double zenith[3];
  compute_zenith(scene, zenith);
  neph_image *image = NULL;
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  desc.width = 4;
  desc.height = 360;
  assert_int_equal(neph_render_sky(scene, &desc, &image), NEPH_OK);
  for (int c = 0; c < 3; c++) {
    const char name[2] = {"RGB"[c], '\0'};
    assert_near_relative((double)neph_image_get_channel(image, name)[0], zenith[c], 0.01);
  }
  assert_true(zenith[2] > zenith[1] && zenith[1] > zenith[0]);
  assert_string_equal(neph_image_get_attribute(image, "nephos:colorSpace"), "rec709");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

static neph_image *render_sky(neph_context *context, const char *wavelengths, const char *elevation) {
  const setting settings[] = {{"render.wavelengths", wavelengths}, {"sun.elevation", elevation}, {"clouds", "[]"}};
  neph_scene *scene = load(context, settings, 3);
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  neph_image *image = NULL;
  desc.width = 16;
  desc.height = 32;
  assert_int_equal(neph_render_sky(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Root mean square over the picture of R, G and B, each over the largest component of its pixel. */
static double compute_error(neph_image *image, neph_image *reference) {
  const float *a[3], *b[3];
  const size_t count = count_pixels(image);
  double sum = 0.0;
  for (int c = 0; c < 3; c++) {
    const char name[2] = {"RGB"[c], '\0'};
    a[c] = neph_image_get_channel(image, name);
    b[c] = neph_image_get_channel(reference, name);
  }
  for (size_t p = 0; p < count; p++) {
    const double largest = fmax(fmax((double)b[0][p], (double)b[1][p]), (double)b[2][p]);
    for (int c = 0; c < 3; c++) sum += pow(((double)a[c][p] - (double)b[c][p]) / largest, 2.0);
  }
  return sqrt(sum / (3.0 * (double)count));
}

/* docs/results/colour.md has 0.1 % against 60 wavelengths; 30 are near enough to those, and half the work. */
static void fifteen_wavelengths_are_enough(void **state) {
  (void)state;
  static const char *const elevations[] = {"40 deg", "0.5 deg"};
  neph_context *context = test_context_create(2, NULL);
  for (int e = 0; e < 2; e++) {
    neph_image *fifteen = render_sky(context, "15", elevations[e]), *thirty = render_sky(context, "30", elevations[e]);
    const double error = compute_error(fifteen, thirty);
    print_message("sun at %s: %.3f %%\n", elevations[e], 100.0 * error);
    assert_true(error < 2e-3);
    neph_image_destroy(fifteen);
    neph_image_destroy(thirty);
  }
  neph_context_destroy(context);
}

/* ---- Headers ---- */

static void headers_say_what_colours_are(void **state) {
  (void)state;
  static const setting acescg[] = {{"output.color_space", "acescg"}, {"output.scale", "0.5"}, {"clouds", "[]"}};
  static const setting bands[] = {
      {"render.wavelengths", "3"}, {"output.color_space", "bands"}, {"output.scale", "0.5"}, {"clouds", "[]"}};
  neph_image *image = render(1, acescg, 3);
  assert_string_equal(neph_image_get_attribute(image, "nephos:colorSpace"), "acescg");
  assert_non_null(strstr(neph_image_get_attribute(image, "nephos:wavelengths"), " nm, "));
  assert_non_null(strstr(neph_image_get_attribute(image, "nephos:white"), "(1, 1, 1) is D65 of 145967 cd m^-2"));
  assert_near_relative(strtod(neph_image_get_attribute(image, "whiteLuminance"), NULL), 145967.0, 1e-5);
  assert_true(image->header.has_chromaticities);
  assert_near((double)image->header.chromaticities[0], 0.713, 1e-6);
  neph_image_destroy(image);
  image = render(1, bands, 4);
  assert_string_equal(neph_image_get_attribute(image, "nephos:colorSpace"), "nephos-bands");
  assert_string_equal(neph_image_get_attribute(image, "nephos:bands"), "680 nm, 550 nm, 440 nm");
  assert_string_equal(neph_image_get_attribute(image, "nephos:white"),
                      "(1, 1, 1) is a radiance of 2 W m^-2 sr^-1 nm^-1 in each band");
  assert_null(neph_image_get_attribute(image, "whiteLuminance"));
  assert_false(image->header.has_chromaticities);
  neph_image_destroy(image);
}

/* Bands show the sun as white; colours have their own. */
static void previews_have_a_white(void **state) {
  (void)state;
  static const setting three[] = {{"render.wavelengths", "3"}, {"output.color_space", "bands"}},
                       dark[] = {{"render.wavelengths", "3"}, {"output.color_space", "bands"}, {"sun.irradiance", "0"}};
  static const double expected[3][3] = {{1.474 / 1.8504, 1.0, 1.91198 / 1.8504}, {1, 1, 1}, {1, 1, 1}};
  neph_context *context = test_context_create(1, NULL);
  neph_scene *scenes[3] = {load(context, three, 2), load(context, NULL, 0), load(context, dark, 3)};
  for (int s = 0; s < 3; s++) {
    neph_output output = NEPH_OUTPUT_DEFAULT;
    assert_int_equal(neph_scene_get_output(scenes[s], &output), NEPH_OK);
    for (int c = 0; c < 3; c++) assert_near(output.preview_desc.white[c], expected[s][c], 1e-15);
    neph_scene_destroy(scenes[s]);
  }
  neph_context_destroy(context);
}

/* ---- Refusals ---- */

static void assert_refused(const setting *settings, size_t count, const char *first, const char *second) {
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_scene *scene = load(context, settings, count);
  neph_image *image = NULL;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&log, first, second);
  assert_null(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

static void wrong_colours_are_refused(void **state) {
  (void)state;
  static const setting seven = {"render.wavelengths", "7"}, bands = {"output.color_space", "bands"};
  assert_refused(&seven, 1, "render.wavelengths is 7", "6 and 9");
  assert_refused(&bands, 1, "output.color_space is bands", "6 render.wavelengths");
}

/* The scene stays as it was. */
static void assert_unset(const char *key, const char *value, const char *allowed) {
  static test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_scene *scene = load(context, NULL, 0);
  assert_int_equal(neph_scene_set(scene, key, value), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&log, key, value, allowed);
  assert_int_equal(scene->render.wavelength_count, 6);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
}

static void values_out_of_range_are_refused(void **state) {
  (void)state;
  assert_unset("render.wavelengths", "0", "[3, 300]");
  assert_unset("render.wavelengths", "303", "[3, 300]");
  assert_unset("render.wavelengths", "4.5", "a whole number");
  assert_unset("output.color_space", "srgb", "rec709, acescg, rec2020, xyz or bands");
}

static neph_result render_verbosely(neph_context *context, void *user) {
  context->log_level_max = NEPH_LOG_DEBUG;
  return test_render_once(context, user);
}

/* Without air and clouds what is left to allocate is what packets are kept in, and the predictions of the log. */
static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  static char text[] = "atmosphere: none\ncamera: {resolution: [2, 2]}\nrender: {samples: 1, wavelengths: 9}\n";
  assert_survives_failed_allocations(render_verbosely, text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(components_add_up_to_the_beauty),
      cmocka_unit_test(errors_of_packets_add_before_they_are_squared),
      cmocka_unit_test(a_furnace_has_the_colour_of_its_light),
      cmocka_unit_test(the_sky_is_the_sum_of_its_packets),
      cmocka_unit_test(fifteen_wavelengths_are_enough),
      cmocka_unit_test(headers_say_what_colours_are),
      cmocka_unit_test(previews_have_a_white),
      cmocka_unit_test(wrong_colours_are_refused),
      cmocka_unit_test(values_out_of_range_are_refused),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
