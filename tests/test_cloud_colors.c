/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds whose file has colours: their albedo, place by place, and the light that they emit, in both integrators,
 * against clouds of one albedo and closed forms. */
#include <nephos/nephos.h>

#include "core/file.h"
#include "test_color_files.h"
#include "volume/volume_tint.h"

typedef test_fixture fixture;

static int set_up(void **state) { return test_set_up_cached(state, 2, "colors.vdb"); }

/* ---- Files ---- */

/* A slab across the view, which ends inside the lattice. */
static float get_slab(const int32_t at[3]) {
  bool is_inside = at[1] >= 10 && at[1] < 22;
  for (int a = 0; a < 3; a += 2) is_inside = is_inside && at[a] >= 4 && at[a] < 28;
  return is_inside ? 0.25f : 0.0f;
}

static float get_left(const int32_t at[3]) { return at[0] < 16 ? get_slab(at) : 0.0f; }
static float get_right(const int32_t at[3]) { return at[0] < 16 ? 0.0f : get_slab(at); }

/* Thin enough for light that is scattered once, in a ball of all densities. */
static float get_ball(const int32_t at[3]) {
  const float x = (float)at[0] - 15.5f, y = (float)at[1] - 15.5f, z = (float)at[2] - 15.5f;
  return fmaxf(1.0f - (x * x + y * y + z * z) / 144.0f, 0.0f);
}

static void set(float out[3], float r, float g, float b) { out[0] = r, out[1] = g, out[2] = b; }

static void get_white(const int32_t at[3], float out[3]) { (void)at, set(out, 1.0f, 1.0f, 1.0f); }
static void get_amber(const int32_t at[3], float out[3]) { (void)at, set(out, 0.75f, 0.5f, 0.25f); }
static void get_halves(const int32_t at[3], float out[3]) {
  at[0] < 16 ? set(out, 0.75f, 0.5f, 0.25f) : set(out, 0.25f, 0.5f, 0.875f);
}
static void get_bright(const int32_t at[3], float out[3]) { set(out, at[0] < 16 ? 1.5f : 0.5f, 0.5f, -0.25f); }
static void get_hole(const int32_t at[3], float out[3]) { set(out, at[0] == 16 ? NAN : 0.5f, 0.5f, 0.5f); }
static void get_flow(const int32_t at[3], float out[3]) { (void)at, set(out, 20.0f, 0.0f, 5.0f); }
static void get_light(const int32_t at[3], float out[3]) { (void)at, set(out, 0.5f, 0.25f, 0.125f); }
static void get_two_lights(const int32_t at[3], float out[3]) {
  at[0] < 16 ? set(out, 0.5f, 0.0f, 0.0f) : set(out, 0.0f, 0.0f, 0.25f);
}

/* A colour of each voxel. */
static void get_confetti(const int32_t at[3], float out[3]) {
  for (int c = 0; c < 3; c++)
    out[c] = (float)((at[0] * 7 + at[1] * 13 + at[2] * 29 + c * 17 * (1 + at[2] % 3)) % 64) / 63.0f;
}

static void write_file(fixture *f, float (*density)(const int32_t[3]), const char *name, test_color_fn *color) {
  const test_color_file file = {density, {{{name}, color}}};
  test_color_write(f->context, f->path, &file);
}

/* ---- Scenes ---- */

static const char lit[] =
    "version: 1\n"
    "environment: {planet: none, radiance: 0}\n"
    "camera: {position: [16 m, -80 m, 16 m], look_at: [16 m, 0 m, 16 m], fov: 24 deg, resolution: [16, 16]}\n"
    "sun: {elevation: 30 deg, azimuth: 215 deg}\n"
    "clouds: [{name: smoke, vdb: \"%s\", phase: {hg: 0.6}, extinction: 1 1/m%s}]\n"
    "render: {integrator: %s, samples: 16%s}\n"
    "output: {color_space: %s}\n";

typedef struct look {
  const char *path, *cloud, *render, *color_space;
} look;

static neph_scene *load(fixture *f, const look *l, neph_integrator integrator) {
  char text[2048];
  (void)snprintf(text, sizeof text, lit, l->path ? l->path : f->path, l->cloud ? l->cloud : "",
                 integrator == NEPH_INTEGRATOR_PATH ? "path" : "march", l->render ? l->render : "",
                 l->color_space ? l->color_space : "bands");
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, text, "colors.yaml", &scene)) fail_msg("%s", f->log.text);
  return scene;
}

static neph_image *render(fixture *f, neph_scene *scene) {
  neph_image *image = NULL;
  test_log_clear(&f->log);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  return image;
}

static neph_image *draw(fixture *f, const look *l, neph_integrator integrator) {
  neph_scene *scene = load(f, l, integrator);
  neph_image *image = render(f, scene);
  neph_scene_destroy(scene);
  return image;
}

static const char *const channels[] = {"R", "G", "B"};

/* Every channel of every pixel, and that there is something to see. */
static void assert_same(neph_image *a, neph_image *b, double tolerance) {
  double sum = 0.0;
  for (int c = 0; c < 3; c++) {
    const float *one = neph_image_get_channel(a, channels[c]), *other = neph_image_get_channel(b, channels[c]);
    const size_t count = (size_t)neph_image_get_width(a) * neph_image_get_height(a);
    for (size_t p = 0; p < count; p++) {
      assert_near((double)one[p], (double)other[p], tolerance * fabs((double)other[p]));
      sum += fabs((double)one[p]);
    }
  }
  assert_true(sum > 0.0);
  neph_image_destroy(a);
  neph_image_destroy(b);
}

static double compute_mean(neph_image *image, int channel) {
  const float *values = neph_image_get_channel(image, channels[channel]);
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  double sum = 0.0;
  for (size_t p = 0; p < count; p++) sum += (double)values[p];
  return sum / (double)count;
}

/* ---- Albedo ---- */

/* Its voxels' shares are those of the corners of the box of its colours: together the density, and the density times
 * the colour. Floats of the sum of at most four shares, of which those below 2⁻¹¹ go to another corner. */
static void parts_add_up_to_the_colors(void **state) {
  fixture *f = *state;
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  np_tint *tint;
  load.precision = NEPH_PRECISION_FLOAT;
  write_file(f, get_ball, "Cd", get_confetti);
  assert_int_equal(neph_volume_load(f->context, f->path, &load, &volume), NEPH_OK);
  const np_tint_source source = {f->path, NULL, &load, volume};
  assert_int_equal(np_tint_create(f->context, &source, NULL, &tint), NEPH_OK);
  assert_int_equal(tint->count, NP_TINT_PARTS_MAX);
  for (int32_t n = 0; n < TEST_COLOR_EDGE * TEST_COLOR_EDGE * TEST_COLOR_EDGE; n++) {
    const int32_t at[3] = {n >> 10, n >> 5 & 31, n & 31};
    const np_dvec3 index = np_dvec3_make(at[0], at[1], at[2]);
    float color[3];
    double sum = 0.0, tinted[3] = {0.0, 0.0, 0.0};
    get_confetti(at, color);
    for (unsigned k = 0; k < tint->count; k++) {
      const double own = (double)np_bricks_sample(&tint->parts[k].volume->bricks, index);
      sum += own;
      for (int c = 0; c < 3; c++) tinted[c] += own * tint->parts[k].color[c];
    }
    assert_near(sum, (double)get_ball(at), 1e-6);
    for (int c = 0; c < 3; c++) assert_near(tinted[c], (double)(get_ball(at) * color[c]), 1e-3);
  }
  np_tint_destroy(tint);
  neph_volume_release(volume);
}

/* The same bits: a cloud of one colour is a cloud of that albedo, in every space of colours and by every method. */
static void one_color_is_an_albedo(void **state) {
  static const char *const spaces[] = {"bands", "rec709"};
  static const char *const methods[] = {"", ", multiple_scattering: octaves", ", max_scatterings: 1"};
  fixture *f = *state;
  write_file(f, get_slab, "Cd", get_amber);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++)
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
      if (i == NEPH_INTEGRATOR_PATH && m == 1) continue;
      const char *space = spaces[(m + (i == NEPH_INTEGRATOR_PATH)) % 2];
      const look colored = {.cloud = ", albedo: 0.9375", .render = methods[m], .color_space = space};
      const look plain = {
          .cloud = ", color: none, albedo: [0.703125, 0.46875, 0.234375]", .render = methods[m], .color_space = space};
      assert_same(draw(f, &colored, i), draw(f, &plain, i), 0.0);
    }
}

/* Nothing is lost and nothing comes of itself: a white cloud in even light is not to be seen. The tracer's paths bring
 * the light they meet, each of them 1; the march has its tolerance, and the same bits as without a grid. */
static void a_white_furnace_stays_white(void **state) {
  fixture *f = *state;
  write_file(f, get_slab, "Cd", get_white);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    const look white = {.cloud = ", albedo: 1"}, plain = {.cloud = ", albedo: 1, color: none"};
    neph_image *images[2];
    for (int k = 0; k < 2; k++) {
      neph_scene *scene = load(f, k ? &plain : &white, i);
      assert_int_equal(neph_scene_set(scene, "environment.radiance", "1"), NEPH_OK);
      assert_int_equal(neph_scene_set(scene, "sun.irradiance", "0"), NEPH_OK);
      images[k] = render(f, scene);
      neph_scene_destroy(scene);
    }
    for (int c = 0; c < 3; c++) assert_near(compute_mean(images[0], c), 1.0, i == NEPH_INTEGRATOR_PATH ? 1e-5 : 0.02);
    assert_same(images[0], images[1], 0.0);
  }
}

/* A file whose halves have a colour each is two files with a half each, of those albedos: the same bits, also as they
 * move. */
static void two_halves_are_two_clouds(void **state) {
  fixture *f = *state;
  char *left = test_path(f->folder, "left.vdb"), *right = test_path(f->folder, "right.vdb"), text[1024];
  const test_color_file whole = {get_slab, {{{"Cd"}, get_halves}, {{"vel"}, get_flow}}};
  const test_color_file halves[] = {{get_left, {{{"vel"}, get_flow}}}, {get_right, {{{"vel"}, get_flow}}}};
  test_color_write(f->context, f->path, &whole);
  test_color_write(f->context, left, &halves[0]);
  test_color_write(f->context, right, &halves[1]);
  (void)snprintf(text, sizeof text,
                 "[{name: left, vdb: \"%s\", extinction: 1 1/m, phase: {hg: 0.6}, albedo: [0.75, 0.5, 0.25]}, {name: "
                 "right, vdb: \"%s\", extinction: 1 1/m, phase: {hg: 0.6}, albedo: [0.25, 0.5, 0.875]}]",
                 left, right);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++)
    for (int moves = 0; moves < 2; moves++) {
      neph_image *images[2];
      for (int k = 0; k < 2; k++) {
        neph_scene *scene = load(f, &(look){.cloud = ", albedo: 1"}, i);
        if (k) assert_int_equal(neph_scene_set(scene, "clouds", text), NEPH_OK);
        if (moves) assert_int_equal(neph_scene_set(scene, "camera.motion_blur", "{}"), NEPH_OK);
        images[k] = render(f, scene);
        neph_scene_destroy(scene);
      }
      assert_same(images[0], images[1], 0.0);
    }
  free(left);
  free(right);
}

/* Light that is scattered once is the white cloud's, times the pixel's colour; but in the middle, where it is of both.
 * The march's steps are cut where a part ends, which moves their light by a percent. */
static void light_scattered_once_has_the_color(void **state) {
  static const double colors[2][3] = {{0.75, 0.5, 0.25}, {0.25, 0.5, 0.875}};
  fixture *f = *state;
  write_file(f, get_slab, "Cd", get_halves);
  const look tinted = {.cloud = ", albedo: 1", .render = ", max_scatterings: 1"};
  const look white = {.cloud = ", albedo: 1, color: none", .render = ", max_scatterings: 1"};
  neph_image *image = draw(f, &tinted, NEPH_INTEGRATOR_MARCH), *plain = draw(f, &white, NEPH_INTEGRATOR_MARCH);
  for (int c = 0; c < 3; c++) {
    const float *own = neph_image_get_channel(image, channels[c]), *of = neph_image_get_channel(plain, channels[c]);
    for (int p = 0; p < 16 * 16; p++) {
      const double expected = colors[p % 16 > 8][c] * (double)of[p];
      if (p % 16 != 7 && p % 16 != 8) assert_near((double)own[p], expected, 0.02 * expected);
    }
  }
  neph_image_destroy(image);
  neph_image_destroy(plain);
}

/* The tracer is the march's reference in many colours too. The march errs by a percent or two here, and 256 pixels of
 * 256 paths by as much. */
static void integrators_agree_on_colors(void **state) {
  fixture *f = *state;
  double mean[2][3];
  write_file(f, get_ball, "color", get_confetti);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, &(look){.cloud = ", albedo: 0.99"}, i);
    assert_int_equal(neph_scene_set(scene, "clouds[0].extinction", "0.2 1/m"), NEPH_OK);
    if (i == NEPH_INTEGRATOR_PATH) assert_int_equal(neph_scene_set(scene, "render.samples", "256"), NEPH_OK);
    neph_image *image = render(f, scene);
    for (int c = 0; c < 3; c++) mean[i == NEPH_INTEGRATOR_PATH][c] = compute_mean(image, c);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
  for (int c = 0; c < 3; c++) {
    print_message("%s: march %.5g, path %.5g\n", channels[c], mean[0][c], mean[1][c]);
    assert_near_relative(mean[0][c], mean[1][c], 0.05);
  }
}

/* ---- Names and values ---- */

static void grids_are_found_by_name(void **state) {
  static const struct {
    const char *names[3], *key;
    bool is_found;
  } cases[] = {{{"Cd"}, "", true},
               {{"color_r", "color_g", "color_b"}, "", true},
               {{"color.R", "color.G", "color.B"}, "", true},
               {{"albedo.x", "albedo.y", "albedo.z"}, "", true},
               {{"dye"}, ", color: dye", true},
               {{"dye"}, "", false},
               {{"Cd"}, ", color: none", false}};
  fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    test_color_file file = {get_slab, {{{NULL}, get_amber}}};
    memcpy(file.colors[0].names, cases[i].names, sizeof file.colors[0].names);
    test_color_write(f->context, f->path, &file);
    neph_image *image =
        draw(f, &(look){.cloud = cases[i].key, .render = ", max_scatterings: 1"}, NEPH_INTEGRATOR_MARCH);
    const double ratio = compute_mean(image, 2) / compute_mean(image, 0);
    assert_true(cases[i].is_found == (ratio < 0.5)); /* 1/3 times the sun's own, or that */
    neph_image_destroy(image);
  }
}

static void colors_beyond_one_are_clamped(void **state) {
  fixture *f = *state;
  const look one = {.render = ", max_scatterings: 1"};
  write_file(f, get_slab, "Cd", get_bright);
  test_log_clear(&f->log);
  neph_image_destroy(draw(f, &one, NEPH_INTEGRATOR_MARCH));
  /* 24·12·24 voxels, all with a negative blue */
  assert_non_null(strstr(f->log.text, "grid 'Cd': the colours of 6912 voxels are not in [0, 1]"));
}

static void broken_colors_are_refused_or_repaired(void **state) {
  fixture *f = *state;
  neph_image *image = NULL;
  write_file(f, get_slab, "Cd", get_hole);
  neph_scene *scene = load(f, &(look){.cloud = ""}, NEPH_INTEGRATOR_MARCH);
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "grid 'Cd'", "NaN, the first (nan) at voxel", "must be finite: clouds[].import: repair");
  assert_int_equal(neph_scene_set(scene, "clouds[0].import", "repair"), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_image_destroy(image);
  assert_int_equal(neph_scene_set(scene, "clouds[0].color", "paint"), NEPH_OK);
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "no grid 'paint' of vectors", "it is the color that the scene names");
  neph_scene_destroy(scene);
}

/* ---- Emission ---- */

/* ∫ j ds through 12 voxels of 1 m, which begin and end in a ramp of one: 12 m of 0.5, 0.25 and 0.125. In absorbing
 * smoke of the extinction σ the same j makes j/σ·(1 − e^{−σL}), whose ramps add less than 1 %. */
static void emitted_colors_add_up_along_the_view(void **state) {
  static const double j[3] = {0.5, 0.25, 0.125};
  fixture *f = *state;
  write_file(f, get_slab, "Ce", get_light);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++)
    for (int absorbs = 0; absorbs < 2; absorbs++) {
      neph_scene *scene = load(f, &(look){.cloud = ", albedo: 0, emission: {strength: 2}"}, i);
      assert_int_equal(neph_scene_set(scene, "clouds[0].extinction", absorbs ? "1 1/m" : "0 1/m"), NEPH_OK);
      assert_int_equal(neph_scene_set(scene, "camera.fov", "4 deg"), NEPH_OK);
      neph_image *image = render(f, scene);
      const double sigma = 0.25, length = 12.0;
      const double expected = absorbs ? (1.0 - exp(-sigma * length)) / sigma : length;
      for (int c = 0; c < 3; c++)
        assert_near_relative(compute_mean(image, c), 2.0 * j[c] * expected, absorbs ? 0.015 : 0.005);
      neph_image_destroy(image);
      neph_scene_destroy(scene);
    }
}

/* Red light comes from the left, blue from the right, and it lights the cloud around it the same in both integrators:
 * the tracer's mean has 3 %. */
static void emitted_colors_light_the_cloud(void **state) {
  fixture *f = *state;
  double mean[2][3];
  const test_color_file file = {get_slab, {{{"emission_r", "emission_g", "emission_b"}, get_two_lights}}};
  test_color_write(f->context, f->path, &file);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    neph_scene *scene = load(f, &(look){.cloud = ", albedo: 0.9, emission: {}"}, i);
    assert_int_equal(neph_scene_set(scene, "sun.irradiance", "0"), NEPH_OK);
    neph_image *image = render(f, scene);
    const float *red = neph_image_get_channel(image, "R"), *blue = neph_image_get_channel(image, "B");
    assert_true(red[8 * 16 + 4] > 2.0f * red[8 * 16 + 12] && blue[8 * 16 + 12] > 2.0f * blue[8 * 16 + 4]);
    for (int c = 0; c < 3; c++) mean[i == NEPH_INTEGRATOR_PATH][c] = compute_mean(image, c);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
  print_message("red: march %.4g, path %.4g; blue: %.4g, %.4g\n", mean[0][0], mean[1][0], mean[0][2], mean[1][2]);
  assert_near_relative(mean[0][0], mean[1][0], 0.03);
  assert_near_relative(mean[0][2], mean[1][2], 0.03);
  assert_true(mean[0][1] == 0.0 && mean[1][1] == 0.0);
}

/* ---- Failures ---- */

static neph_result attempt(neph_context *context, void *user) {
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  np_tint *tint = NULL;
  neph_result result = neph_volume_load(context, user, &load, &volume);
  if (result) return result;
  const np_tint_source source = {user, NULL, &load, volume};
  result = np_tint_create(context, &source, NULL, &tint);
  np_tint_destroy(tint);
  neph_volume_release(volume);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  fixture *f = *state;
  write_file(f, get_slab, "Cd", get_halves);
  assert_survives_failed_allocations(attempt, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(parts_add_up_to_the_colors, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(one_color_is_an_albedo, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_white_furnace_stays_white, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(two_halves_are_two_clouds, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(light_scattered_once_has_the_color, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(integrators_agree_on_colors, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(grids_are_found_by_name, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(colors_beyond_one_are_clamped, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(broken_colors_are_refused_or_repaired, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(emitted_colors_add_up_along_the_view, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(emitted_colors_light_the_cloud, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
