/* SPDX-License-Identifier: Apache-2.0 */
/* Outputs of `nephos sky`: harmonics, the disk in its layer, tables as pictures, their measured errors. */
#include "test_contexts.h"

#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "image/exposure.h"
#include "image/preview.h"
#include "image/preview_tone.h"
#include "stages/sky_harmonics.h"

static neph_scene *load(neph_context *context, const char *text) {
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(context, text, "scene", &scene), NEPH_OK);
  return scene;
}

/* The sky by longitude and latitude. */
static neph_image *paint(neph_scene *scene, unsigned width) {
  neph_image *image;
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  desc.width = width;
  desc.height = width / 2;
  assert_int_equal(neph_render_sky(scene, &desc, &image), NEPH_OK);
  return image;
}

static const char day[] =
    "{camera: {position: [0, 0, 5 m], look_at: [0, 100 m, 5 m]}, sun: {elevation: 35 deg, azimuth: 60 deg},"
    " output: {color_space: bands}}";

/* ---- Harmonics ---- */

static np_spectrum radiate_evenly(const void *user, np_vec3 d) {
  (void)user;
  (void)d;
  return np_spectrum_grey(1.0f);
}

static np_spectrum radiate_from_above(const void *user, np_vec3 d) {
  (void)user;
  return np_spectrum_grey(1.0f + d.z);
}

/* Irradiance on a surface that faces `normal`: Σ Aₗ·Lk·Yk(normal), A = π, 2π/3, π/4. */
static void compute_irradiance(double harmonics[NP_SKY_HARMONICS][NP_BAND_COUNT], np_vec3 normal,
                               double out[NP_BAND_COUNT]) {
  double harmonic[NP_SKY_HARMONICS];
  np_sky_harmonics_eval(normal, harmonic);
  for (int b = 0; b < NP_BAND_COUNT; b++) out[b] = 0.0;
  for (int k = 0; k < NP_SKY_HARMONICS; k++) {
    const double weight = k == 0 ? NP_PI : k < 4 ? 2.0 * NP_PI / 3.0 : NP_PI / 4.0;
    for (int b = 0; b < NP_BAND_COUNT; b++) out[b] += weight * harmonics[k][b] * harmonic[k];
  }
}

/* An even sky has one coefficient, √(4π), and brings every surface π. To 1e-5: the grid's floats. */
static void harmonics_of_an_even_sky(void **state) {
  (void)state;
  double h[NP_SKY_HARMONICS][NP_BAND_COUNT], e[NP_BAND_COUNT];
  np_sky_harmonics_project(radiate_evenly, NULL, h);
  assert_near(h[0][1], sqrt(4.0 * NP_PI), 1e-4);
  for (int k = 1; k < NP_SKY_HARMONICS; k++) assert_near(h[k][1], 0.0, 1e-4);
  compute_irradiance(h, np_vec3_make(0.6f, 0, 0.8f), e);
  assert_near(e[1], NP_PI, 1e-4);
}

/* L = 1 + z: its one further coefficient is √(4π/3), and a surface at an angle θ from up gets π + (2π/3)·cosθ. */
static void harmonics_of_a_sky_brighter_above(void **state) {
  (void)state;
  double h[NP_SKY_HARMONICS][NP_BAND_COUNT], e[NP_BAND_COUNT];
  np_sky_harmonics_project(radiate_from_above, NULL, h);
  assert_near(h[2][0], sqrt(4.0 * NP_PI / 3.0), 1e-3);
  assert_near(h[1][0], 0.0, 1e-4);
  assert_near(h[3][0], 0.0, 1e-4);
  compute_irradiance(h, np_vec3_make(0, 0.8f, 0.6f), e);
  assert_near(e[0], NP_PI + 2.0 * NP_PI / 3.0 * 0.6, 1e-3);
}

static void read_numbers(const neph_image *image, const char *name, double *out, int count) {
  const char *text = neph_image_get_attribute(image, name);
  assert_non_null(text);
  for (int i = 0; i < count; i++) {
    char *rest;
    out[i] = strtod(text, &rest);
    assert_true(rest > text);
    text = rest;
  }
}

/* Irradiance of a picture's sky on a surface. */
static double integrate(neph_image *image, np_vec3 normal, const char *name) {
  const float *plane = neph_image_get_channel(image, name);
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  double sum = 0.0;
  for (unsigned y = 0; y < height; y++) {
    const double top = NP_PI * y / height, bottom = NP_PI * (y + 1) / height, zenith = 0.5 * (top + bottom);
    const double solid_angle = (cos(top) - cos(bottom)) * 2.0 * NP_PI / width;
    for (unsigned x = 0; x < width; x++) {
      const double azimuth = 2.0 * NP_PI * (x + 0.5) / width;
      const double cosine = sin(zenith) * sin(azimuth) * (double)normal.x +
                            sin(zenith) * cos(azimuth) * (double)normal.y + cos(zenith) * (double)normal.z;
      sum += solid_angle * fmax(cosine, 0.0) * (double)plane[y * width + x];
    }
  }
  return sum;
}

/* Irradiance by order 2, over surfaces that face all ways, is known to be good to 1 to 3 % of the mean one; on single
 * ones a clear sky's bright horizon makes more of it. */
static void harmonics_give_a_clear_skys_irradiance(void **state) {
  neph_scene *scene = load(*state, day);
  neph_image *image = paint(scene, 256);
  double h[NP_SKY_HARMONICS][NP_BAND_COUNT], e[NP_BAND_COUNT];
  read_numbers(image, "nephos:skyHarmonics", h[0], NP_SKY_HARMONICS * NP_BAND_COUNT);
  static const char *const names[] = {"R", "G", "B"};
  for (int b = 0; b < 3; b++) {
    enum { NORMALS = 60 };
    double square = 0.0, mean = 0.0;
    for (int i = 0; i < NORMALS; i++) {
      const double z = 1.0 - (2.0 * i + 1.0) / NORMALS, turn = 2.0 * NP_PI * fmod(i * 0.6180339887, 1.0);
      const double s = sqrt(1.0 - z * z);
      const np_vec3 normal = np_vec3_make((float)(s * cos(turn)), (float)(s * sin(turn)), (float)z);
      const double reference = integrate(image, normal, names[b]);
      compute_irradiance(h, normal, e);
      square += (e[b] - reference) * (e[b] - reference) / NORMALS;
      mean += reference / NORMALS;
    }
    print_message("irradiance by harmonics, band %d: %.2f %% of the mean rms\n", b, 100.0 * sqrt(square) / mean);
    assert_true(sqrt(square) <= 0.03 * mean);
  }
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* ---- The disk ---- */

static double sum_plane(neph_image *image, const char *name) {
  const float *plane = neph_image_get_channel(image, name);
  assert_non_null(plane);
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  double sum = 0.0;
  for (unsigned y = 0; y < height; y++) {
    const double top = NP_PI * y / height, bottom = NP_PI * (y + 1) / height;
    const double solid_angle = (cos(top) - cos(bottom)) * 2.0 * NP_PI / width, cosine = cos(0.5 * (top + bottom));
    for (unsigned x = 0; x < width; x++) sum += solid_angle * fmax(cosine, 0.0) * (double)plane[y * width + x];
  }
  return sum;
}

/* The layer's light on a level surface is the sun's irradiance: to 1 %, for a pixel's averages have 4 to 64 probes a
 * side. The sky's own layer has no disk: no pixel of it is as bright as the mean disk. */
static void the_disk_is_a_layer_of_its_own(void **state) {
  static const char *const names[] = {"disk.R", "disk.G", "disk.B"};
  neph_scene *scene = load(*state, day);
  neph_image *image = paint(scene, 512);
  double sun[3];
  read_numbers(image, "nephos:sunIrradiance", sun, 3);
  for (int b = 0; b < 3; b++) assert_near_relative(sum_plane(image, names[b]), sun[b], 0.01);
  const float *sky = neph_image_get_channel(image, "G");
  for (size_t i = 0; i < 512 * 256; i++) assert_true(sky[i] < 100.0f);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* ---- Preview ---- */

static double encode(double linear) {
  return 255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055);
}

/* Rms difference of means over blocks of 8 × 8 pixels, in steps of 8 bits, of what the picture is to show and of the
 * file; within a step of black and white, where dither fades out, nothing is counted. */
static double measure_banding(neph_context *context, neph_image *image, const char *path, neph_view view,
                              double exposure_ev) {
  static const char *const names[] = {"R", "G", "B"};
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.view = view;
  desc.glare = 0.0; /* the picture is of all directions, and has none */
  desc.exposure_ev = exposure_ev;
  neph_image *loaded;
  assert_int_equal(neph_image_save_png(image, path, &desc), NEPH_OK);
  assert_int_equal(neph_image_load_png(context, path, &loaded), NEPH_OK);
  const double exposure = np_exposure_choose_by_picture(image, &desc) * exp2(exposure_ev);
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  const float *planes[3], *shown[3];
  for (int b = 0; b < 3; b++) {
    planes[b] = neph_image_get_channel(image, names[b]);
    shown[b] = neph_image_get_channel(loaded, names[b]);
  }
  double square = 0.0;
  unsigned count = 0;
  for (unsigned block = 0; block < width / 8 * (height / 8); block++) {
    double off[3] = {0}, least[3] = {255, 255, 255}, greatest[3] = {0};
    for (unsigned i = 0; i < 64; i++) {
      const size_t at = (size_t)(block / (width / 8) * 8 + i / 8) * width + block % (width / 8) * 8 + i % 8;
      float exposed[3], display[3];
      for (int b = 0; b < 3; b++) exposed[b] = (float)(exposure * (double)planes[b][at]);
      np_preview_get_view(view)->map(exposed, display);
      for (int b = 0; b < 3; b++) {
        const double wanted = encode((double)display[b]);
        off[b] += (255.0 * (double)shown[b][at] - wanted) / 64.0;
        least[b] = fmin(least[b], wanted);
        greatest[b] = fmax(greatest[b], wanted);
      }
    }
    for (int b = 0; b < 3; b++) {
      if (least[b] < 1.0 || greatest[b] > 254.0) continue;
      square += off[b] * off[b];
      count++;
    }
  }
  neph_image_destroy(loaded);
  assert_true(count > 100);
  return sqrt(square / count);
}

/* A smooth sky rounded to 8 bits stands in bands, whose blocks are 0.29 steps off on average (1/√12). With one step of
 * dither, a block's mean is off by 0.5/8 at the most. */
static void a_smooth_sky_shows_no_bands(void **state) {
  neph_scene *scene = load(*state, day);
  neph_image *image = paint(scene, 512);
  char *folder = test_folder_create(), *path = test_path(folder, "sky.png");
  static const neph_view views[] = {NEPH_VIEW_FILMIC, NEPH_VIEW_CAMERA};
  for (int v = 0; v < 2; v++)
    for (int ev = -8; ev <= 8; ev += 4) {
      const double off = measure_banding(*state, image, path, views[v], ev);
      print_message("%s: at %+d stops blocks are %.3f steps off\n", np_preview_name_view(views[v]), ev, off);
      assert_true(off <= 0.0625);
    }
  free(path);
  test_folder_destroy(folder);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

/* ---- Tables ---- */

static void every_table_is_a_picture(void **state) {
  neph_scene *scene = load(*state, day);
  for (int t = 0; t < NEPH_SKY_TABLE_COUNT; t++) {
    neph_image *image;
    assert_int_equal(neph_render_sky_table(scene, (neph_sky_table)t, &image), NEPH_OK);
    const float *green = neph_image_get_channel(image, "G");
    const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
    float least = INFINITY, greatest = 0.0f;
    for (size_t i = 0; i < count; i++) {
      assert_true(isfinite(green[i]) && green[i] >= 0.0f);
      least = fminf(least, green[i]);
      greatest = fmaxf(greatest, green[i]);
    }
    assert_true(greatest > least); /* there is something to see */
    if (t <= NEPH_SKY_TABLE_SCATTERING) assert_true(greatest <= 1.0f);
    neph_image_destroy(image);
  }
  neph_scene_destroy(scene);
}

static void tables_that_are_not_are_refused(void **state) {
  neph_scene *scene = load(*state, "{atmosphere: none}");
  neph_image *image;
  char *text;
  assert_int_equal(neph_render_sky_table(scene, NEPH_SKY_TABLE_VIEW, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(image);
  assert_int_equal(neph_render_sky_table(scene, NEPH_SKY_TABLE_COUNT, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_int_equal(neph_render_sky_verify(scene, NULL, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(text);
  neph_sky_verify_desc desc = NEPH_SKY_VERIFY_DESC_DEFAULT;
  desc.path_count = 0;
  assert_int_equal(neph_render_sky_verify(scene, &desc, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_INVALID_ARGUMENT);
  neph_scene_destroy(scene);
}

/* The first number after a name, of JSON that the library wrote. */
static double read_number(const char *text, const char *name) {
  const char *at = strstr(text, name);
  assert_non_null(at);
  at = strpbrk(at + strlen(name), "-0123456789");
  assert_non_null(at);
  return strtod(at, NULL);
}

/* Each table by itself within the tolerance that sized it, at the default and at a coarse one, which is worse. 64
 * paths: the traced error is printed, and too noisy to be held to anything here (test_sky_gates is). */
static void measured_errors_are_within_the_tolerance(void **state) {
  neph_scene *scene = load(*state, day);
  neph_sky_verify_desc desc = NEPH_SKY_VERIFY_DESC_DEFAULT;
  desc.path_count = 64;
  double before = 0.0;
  for (int i = 0; i < 2; i++) {
    const double tolerance = i ? 0.1 : 0.007;
    char *text;
    assert_int_equal(neph_scene_set(scene, "atmosphere.tolerance", i ? "0.1" : "0.007"), NEPH_OK);
    assert_int_equal(neph_render_sky_verify(scene, &desc, NEPH_TEXT_JSON, &text), NEPH_OK);
    assert_near(read_number(text, "tolerance"), tolerance, 1e-9);
    assert_true(read_number(text, "optical_depth") <= tolerance);
    assert_true(read_number(text, "sky_view") <= tolerance);
    assert_true(read_number(text, "aerial_perspective") <= tolerance);
    assert_true(read_number(text, "sky_view") > before);
    before = read_number(text, "sky_view");
    neph_text_destroy(*state, text);
  }
  neph_scene_destroy(scene);
}

static int create_context(void **state) {
  *state = test_context_create_cached(2, NULL);
  return 0;
}

static int destroy_context(void **state) {
  neph_context_destroy(*state);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(harmonics_of_an_even_sky),
      cmocka_unit_test(harmonics_of_a_sky_brighter_above),
      cmocka_unit_test(harmonics_give_a_clear_skys_irradiance),
      cmocka_unit_test(the_disk_is_a_layer_of_its_own),
      cmocka_unit_test(a_smooth_sky_shows_no_bands),
      cmocka_unit_test(every_table_is_a_picture),
      cmocka_unit_test(tables_that_are_not_are_refused),
      cmocka_unit_test(measured_errors_are_within_the_tolerance),
  };
  return cmocka_run_group_tests(tests, create_context, destroy_context);
}
