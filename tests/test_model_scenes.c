/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of atmospheric models in scenes: pictures by both integrators, their keys, frames of time steps, and their
 * .vdb files. */
#include "test_models.h"

#include <nephos/nephos.h>

#include "test_films.h"
#include "volume/volume_private.h"

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static const model_file file_of_steps = {.levels = LEVELS_UNEVEN, .step_count = 3, .has_ice = true};

static int set_up(void **state) {
  const int failed = test_set_up(state, 2, "field.nc");
  if (failed) return failed;
  model_write(((test_fixture *)*state)->path, model_get_case("WRF"), &file_of_steps);
  return 0;
}

/* ---- Pictures ---- */

/* A single sample compares fields, by light that is scattered once. */
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
                 "render: {integrator: %s, samples: %u, multiple_scattering: %s}\n"
                 "output: {aovs: [transmittance]}\n",
                 WIDTH, HEIGHT, source, integrator, samples, samples > 1 ? "ordinates" : "none");
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

static bool are_same(neph_image *a, neph_image *b) {
  static const char *const names[] = {"R", "transmittance"};
  bool are = true;
  for (int c = 0; c < 2; c++)
    are =
        are && !memcmp(neph_image_get_values(a, names[c]), neph_image_get_values(b, names[c]), PIXELS * sizeof(float));
  return are;
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
  neph_image *march = render_once(f, "netcdf: field.nc, albedo: 0.95", "march", 16);
  neph_image *path = render_once(f, "netcdf: field.nc, albedo: 0.95", "path", 64);
  assert_true(get_mean(path, "transmittance") < 0.9);
  assert_near(get_mean(march, "transmittance"), get_mean(path, "transmittance"), 0.02);
  assert_near_relative(get_mean(march, "R"), get_mean(path, "R"), 0.06);
  neph_image_destroy(march);
  neph_image_destroy(path);
}

/* ---- Keys ---- */

/* Each key of clouds[].netcdf, and what it is changed to. */
static const struct {
  const char *key, *source;
} changes[] = {
    {"clouds[].netcdf.file", "netcdf: {file: other.nc}"},
    {"clouds[].netcdf.variable", "netcdf: {file: field.nc, variable: none}"},
    {"clouds[].netcdf.ice", "netcdf: {file: field.nc, ice: none}"},
    {"clouds[].netcdf.radius", "netcdf: {file: field.nc, radius: PSFC_RADIUS}"},
    {"clouds[].netcdf.number", "netcdf: {file: field.nc, number: DROPS}"},
    {"clouds[].netcdf.effective_radius", "netcdf: {file: field.nc, effective_radius: 14 um}"},
    {"clouds[].netcdf.ice_effective_radius", "netcdf: {file: field.nc, ice_effective_radius: 60 um}"},
    {"clouds[].netcdf.droplet_number", "netcdf: {file: field.nc, droplet_number: 50 1/cm3}"},
    {"clouds[].netcdf.dispersion", "netcdf: {file: field.nc, droplet_number: 50 1/cm3, dispersion: 0.67}"},
    {"clouds[].netcdf.spacing", "netcdf: {file: field.nc, spacing: 80 m}"},
    {"clouds[].netcdf.step", "netcdf: {file: field.nc, step: 2}"},
};

enum { CHANGES = sizeof changes / sizeof *changes };

/* A further field of constant values on the levels of the water. */
static void add_constant(const test_fixture *f, const char *name, const char *unit, double value) {
  enum { COUNT = 3 * MODEL_CELLS };
  int id, dimensions[4], water, variable;
  double *values = forge_alloc(COUNT);
  for (int i = 0; i < COUNT; i++) values[i] = value;
  forge_check(nc_open(f->path, NC_WRITE, &id));
  forge_check(nc_inq_varid(id, "QCLOUD", &water));
  forge_check(nc_inq_vardimid(id, water, dimensions));
  forge_check(nc_def_var(id, name, NC_FLOAT, 4, dimensions, &variable));
  forge_check(nc_put_att_text(id, variable, "units", strlen(unit), unit));
  forge_check(nc_put_var_double(id, variable, values));
  forge_check(nc_close(id));
  free(values);
}

static void each_key_changes_the_picture(void **state) {
  test_fixture *f = *state;
  neph_image *images[CHANGES + 1];
  static const model_file other = {.levels = LEVELS_EVEN, .step_count = 1};
  char *path = test_path(f->folder, "other.nc");
  model_write(path, model_get_case("WRF"), &other);
  free(path);
  add_constant(f, "PSFC_RADIUS", "um", 6.0);
  add_constant(f, "DROPS", "cm-3", 400.0);
  images[CHANGES] = render_once(f, "netcdf: field.nc", "march", 1);
  for (int i = 0; i < CHANGES; i++) {
    images[i] = render_once(f, changes[i].source, "march", 1);
    for (int k = CHANGES; k > i; k = k == CHANGES ? i : k - 1)
      if (are_same(images[i], images[k])) fail_msg("%s changes nothing", changes[i].key);
    for (int k = 0; k < i; k++)
      if (are_same(images[i], images[k])) fail_msg("%s does what %s does", changes[i].key, changes[k].key);
  }
  for (int i = 0; i <= CHANGES; i++) neph_image_destroy(images[i]);
}

static void a_name_alone_is_the_file(void **state) {
  test_fixture *f = *state;
  neph_image *images[3] = {render_once(f, "netcdf: field.nc", "march", 1),
                           render_once(f, "netcdf: {file: field.nc, step: 1}", "march", 1),
                           render_once(f, "vdb: field.nc", "march", 1)};
  for (int i = 1; i < 3; i++) assert_true(are_same(images[0], images[i]));
  for (int i = 0; i < 3; i++) neph_image_destroy(images[i]);
}

/* An edit of one key keeps the file that a scene names without keys, and a further one keeps both. */
static void edits_keep_the_file(void **state) {
  test_fixture *f = *state;
  test_film film = load(f, "netcdf: field.nc", "march", 1);
  assert_int_equal(neph_scene_set(film.scene, "clouds[0].netcdf.step", "2"), NEPH_OK);
  assert_int_equal(neph_scene_set(film.scene, "clouds[0].netcdf.effective_radius", "14 um"), NEPH_OK);
  neph_image *edited = render_frame(f, film, 1);
  neph_image *written = render_once(f, "netcdf: {file: field.nc, step: 2, effective_radius: 14 um}", "march", 1);
  assert_true(are_same(edited, written));
  neph_image_destroy(edited);
  neph_image_destroy(written);
  film_destroy(film);
}

/* A field with periodic sides is the same cloud by netcdf as by vdb, and has a second box beside it. */
static void fields_repeat(void **state) {
  test_fixture *f = *state;
  char by_netcdf[96], by_vdb[96];
  const double lengths_m[2] = {MODEL_X * model_dx_m, MODEL_Y * model_dy_m};
  (void)snprintf(by_netcdf, sizeof by_netcdf, "netcdf: field.nc, repeat: [%g m, %g m]", lengths_m[0], lengths_m[1]);
  (void)snprintf(by_vdb, sizeof by_vdb, "vdb: field.nc, repeat: [%g m, %g m]", lengths_m[0], lengths_m[1]);
  neph_image *images[3] = {render_once(f, by_netcdf, "march", 1), render_once(f, by_vdb, "march", 1),
                           render_once(f, "netcdf: field.nc", "march", 1)};
  assert_true(are_same(images[0], images[1]));
  assert_true(get_mean(images[0], "transmittance") < get_mean(images[2], "transmittance"));
  for (int i = 0; i < 3; i++) neph_image_destroy(images[i]);
}

static void assert_domain(const test_fixture *f, const char *path) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume, *alone;
  assert_int_equal(neph_volume_load(f->context, path, &desc, &alone), NEPH_OK);
  desc.repeat_m[0] = desc.repeat_m[1] = NEPH_REPEAT_FILE;
  assert_int_equal(neph_volume_load(f->context, path, &desc, &volume), NEPH_OK);
  assert_true(volume->active_max[0] - volume->active_min[0] + 1 < MODEL_X);
  assert_near(volume->bricks.field_period[0], MODEL_X, 0.0);
  assert_near(volume->bricks.field_period[1], MODEL_Y, 0.0);
  for (int a = 0; a < 2; a++) assert_near(volume->index_to_world.m[a][3], alone->index_to_world.m[a][3], 1e-9);
  neph_volume_release(volume);
  neph_volume_release(alone);
}

/* The field has clear margins: its period is the model's domain, from its first column, not the box of its water. So it
 * is in an exported file, which has the sizes of droplets and ice too. */
static void a_file_repeats_by_its_domain(void **state) {
  test_fixture *f = *state;
  neph_exported_cloud exported = NEPH_EXPORTED_CLOUD_DEFAULT;
  char *vdb = test_path(f->folder, "field.vdb");
  const test_film film = load(f, "netcdf: field.nc", "march", 1);
  assert_int_equal(neph_scene_export_cloud(film.scene, 0, 1, NULL, vdb, &exported), NEPH_OK);
  assert_int_equal(exported.fields, NEPH_EXPORT_SIZES);
  assert_domain(f, f->path);
  assert_domain(f, vdb);
  film_destroy(film);
  free(vdb);
}

static void scenes_are_refused(void **state) {
  static const struct {
    const char *source, *message;
  } rows[] = {
      {"netcdf: field.nc, bake: {}", "clouds[0].netcdf is a file that is read: a cloud with it has no bake"},
      {"netcdf: {step: 2}", "clouds[0].netcdf has no file"},
      {"netcdf: field.nc, vdb: field.vdb", "clouds[0].netcdf"},
      {"netcdf: {file: field.nc, step: 0}", "clouds[0].netcdf.step"},
      {"netcdf: {file: field.nc, droplet_number: 5 m}", "clouds[0].netcdf.droplet_number"},
  };
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char text[256];
    neph_scene *scene = NULL;
    (void)snprintf(text, sizeof text, "version: 1\nclouds: [{%s}]\n", rows[i].source);
    test_log_clear(&f->log);
    assert_int_not_equal(neph_scene_load_text(f->context, text, "scene.yaml", &scene), NEPH_OK);
    if (!strstr(f->log.text, rows[i].message)) fail_msg("%s: %s", rows[i].source, f->log.text);
  }
}

/* ---- Frames ---- */

/* Frames show steps, through frame_speed and frame_offset; beyond the last the policy of missing frames holds. */
static void frames_are_steps(void **state) {
  static const struct {
    const char *keys;
    int frame, step; /* step 0: nothing */
  } rows[] = {{"", 2, 2},
              {"", 5, 0},
              {", missing: hold", 5, 3},
              {", missing: loop", 5, 2},
              {", frame_speed: 2", 2, 3},
              {", frame_offset: 1", 2, 3}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    char source[160], fixed[80];
    (void)snprintf(source, sizeof source, "netcdf: {file: field.nc, step: frame}%s", rows[i].keys);
    (void)snprintf(fixed, sizeof fixed, "netcdf: {file: field.nc, step: %d}", rows[i].step);
    const test_film film = load(f, source, "march", 1);
    neph_image_destroy(render_frame(f, film, 1)); /* what it keeps is that of another step */
    neph_image *image = render_frame(f, film, rows[i].frame);
    if (rows[i].step) {
      const test_film of_step = load(f, fixed, "march", 1);
      neph_image *expected = render_frame(f, of_step, rows[i].frame);
      assert_memory_equal(neph_image_get_values(image, "transmittance"),
                          neph_image_get_values(expected, "transmittance"), PIXELS * sizeof(float));
      neph_image_destroy(expected);
      film_destroy(of_step);
    } else
      assert_near(get_mean(image, "transmittance"), 1.0, 0.0);
    neph_image_destroy(image);
    film_destroy(film);
  }
}

/* ---- Files ---- */

/* The exported cloud is the same picture, up to the rounding of its values to halves in memory. */
static void the_exported_cloud_looks_alike(void **state) {
  test_fixture *f = *state;
  neph_exported_cloud exported = NEPH_EXPORTED_CLOUD_DEFAULT;
  char *vdb = test_path(f->folder, "field.vdb");
  const test_film film = load(f, "netcdf: field.nc", "march", 2);
  assert_int_equal(neph_scene_export_cloud(film.scene, 0, 1, NULL, vdb, &exported), NEPH_OK);
  assert_near(exported.extinction_per_value, 1.0, 0.0);
  neph_image *images[2] = {render_frame(f, film, 1), render_once(f, "vdb: field.vdb", "march", 2)};
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
      cmocka_unit_test_setup_teardown(each_key_changes_the_picture, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_name_alone_is_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(edits_keep_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fields_repeat, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_file_repeats_by_its_domain, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(scenes_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(frames_are_steps, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_exported_cloud_looks_alike, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(info_and_check_describe_it, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
