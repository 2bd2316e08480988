/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of atmospheric models in scenes: pictures by both integrators, and their .vdb files. */
#include "test_models.h"

#include <nephos/nephos.h>

#include "test_films.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static const model_file file_of_steps = {.levels = LEVELS_UNEVEN, .step_count = 3, .has_ice = true};

static int set_up(void **state) {
  const int failed = test_set_up(state, 2, "field.nc");
  if (failed) return failed;
  model_write(((test_fixture *)*state)->path, model_get_case("WRF"), &file_of_steps);
  return 0;
}

/* ---- Pictures ---- */

static test_film load(const test_fixture *f, const char *source, const char *integrator, unsigned samples) {
  char text[1600], *path = test_path(f->folder, "scene.yaml");
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [1 km, -2.5 km, 900 m], look_at: [1 km, 480 m, 850 m], fov: 40 deg,\n"
                 "  resolution: [%d, %d]}\n"
                 "sun: {elevation: 25 deg, azimuth: 220 deg}\n"
                 "atmosphere: none\n"
                 "environment: {radiance: 0.1}\n"
                 "clouds: [{%s}]\n"
                 "render: {integrator: %s, samples: %u}\n"
                 "output: {aovs: [transmittance]}\n",
                 WIDTH, HEIGHT, source, integrator, samples);
  const test_film film = film_load(f->context, text, path);
  free(path);
  return film;
}

static neph_image *render_frame(const test_fixture *f, test_film film, int frame) {
  neph_image *image = NULL;
  const neph_result result = film_render(film, frame, &image);
  if (result) print_message("%s", f->log.text);
  assert_int_equal(result, NEPH_OK);
  return image;
}

static neph_image *render_once(const test_fixture *f, const char *source, const char *integrator, unsigned samples) {
  const test_film film = load(f, source, integrator, samples);
  neph_image *image = render_frame(f, film, 1);
  film_destroy(film);
  return image;
}

static double get_mean(neph_image *image, const char *channel) {
  const float *values = neph_image_get_values(image, channel);
  double sum = 0.0;
  for (int i = 0; i < PIXELS; i++) sum += (double)values[i];
  return sum / PIXELS;
}

/* The march, within its stated bias of a few percent, is beside the path in the mean; both see the same cloud. */
static void march_and_path_agree(void **state) {
  test_fixture *f = *state;
  neph_image *march = render_once(f, "vdb: field.nc, albedo: 0.95", "march", 16);
  neph_image *path = render_once(f, "vdb: field.nc, albedo: 0.95", "path", 64);
  assert_true(get_mean(path, "transmittance") < 0.9);
  assert_near(get_mean(march, "transmittance"), get_mean(path, "transmittance"), 0.02);
  assert_near_relative(get_mean(march, "R"), get_mean(path, "R"), 0.06);
  neph_image_destroy(march);
  neph_image_destroy(path);
}

/* ---- Files ---- */

/* The exported cloud is the same picture, up to the rounding of its values to halves in memory. */
static void the_exported_cloud_looks_alike(void **state) {
  test_fixture *f = *state;
  neph_exported_cloud exported = NEPH_EXPORTED_CLOUD_DEFAULT;
  char *vdb = test_path(f->folder, "field.vdb");
  const test_film film = load(f, "vdb: field.nc", "march", 1);
  assert_int_equal(neph_scene_export_cloud(film.scene, 0, 1, NULL, vdb, &exported), NEPH_OK);
  assert_near(exported.extinction_per_value, 1.0, 0.0);
  neph_image *images[2] = {render_frame(f, film, 1), render_once(f, "vdb: field.vdb", "march", 1)};
  const float *a = neph_image_get_values(images[0], "transmittance"),
              *b = neph_image_get_values(images[1], "transmittance");
  for (int i = 0; i < PIXELS; i++) assert_near((double)a[i], (double)b[i], 2e-3);
  assert_near_relative(get_mean(images[0], "R"), get_mean(images[1], "R"), 2e-3);
  for (int i = 0; i < 2; i++) neph_image_destroy(images[i]);
  film_destroy(film);
  free(vdb);
}

static void info_and_check_describe_it(void **state) {
  test_fixture *f = *state;
  char *text = NULL;
  neph_check *check = NULL;
  assert_int_equal(neph_volume_describe_file(f->context, f->path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  static const char *const words[] = {"density", "liquid_water", "ice_water", "WRF", "QCLOUD", "1 of 3", "1/m"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (!strstr(text, words[i])) fail_msg("%s is not in: %s", words[i], text);
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_file(check, f->path), NEPH_OK);
  assert_int_equal(neph_check_count(check, NEPH_SEVERITY_ERROR), 0);
  neph_check_destroy(check);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(march_and_path_agree, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_exported_cloud_looks_alike, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(info_and_check_describe_it, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
