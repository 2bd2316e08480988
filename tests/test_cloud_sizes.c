/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds whose file has the sizes of their droplets: phase functions voxel by voxel, in both integrators, against
 * clouds of one size. */
#include <nephos/nephos.h>

#include "core/math.h"
#include "optics/phase.h"
#include "test_support.h"
#include "volume/volume_sizes.h"

enum { EDGE = 32, WIDTH = 16, PIXELS = WIDTH * WIDTH };

typedef test_fixture fixture;

static int set_up(void **state) { return test_set_up(state, 2, "sizes.vdb"); }

/* ---- Files: voxels of 1 m ---- */

typedef float value_fn(const int32_t at[3]);

/* A slab across the view, which ends inside the lattice. */
static float get_slab(const int32_t at[3]) {
  bool is_inside = at[1] >= 10 && at[1] < 22;
  for (int a = 0; a < 3; a += 2) is_inside = is_inside && at[a] >= 2 && at[a] < 30;
  return is_inside ? 0.25f : 0.0f;
}

static float get_left(const int32_t at[3]) { return at[0] < 16 ? get_slab(at) : 0.0f; }
static float get_right(const int32_t at[3]) { return at[0] < 16 ? 0.0f : get_slab(at); }

/* Effective radii in um: one; one of each half; and from 5 to 15 um across the view. */
static float get_one(const int32_t at[3]) { return (void)at, 7.5f; }
static float get_halves(const int32_t at[3]) { return at[0] < 16 ? 5.0f : 20.0f; }
static float get_slope(const int32_t at[3]) { return 5.0f + 10.0f * ((float)at[0] - 2.0f) / 27.0f; }
static float get_metres(const int32_t at[3]) { return 1e-6f * get_slope(at); }
static float get_hole(const int32_t at[3]) { return at[0] == 16 ? NAN : 8.0f; }
static float get_gap(const int32_t at[3]) { return at[0] < 4 ? 0.0f : 8.0f; }

static void fill(neph_context *context, const char *name, value_fn *value, np_sparse_grid *grid) {
  int32_t o[3];
  assert_int_equal(np_sparse_grid_init(context, name, grid), NEPH_OK);
  grid->index_to_world = np_affine_identity();
  for (o[0] = 0; o[0] < EDGE; o[0] += NP_LEAF_EDGE)
    for (o[1] = 0; o[1] < EDGE; o[1] += NP_LEAF_EDGE)
      for (o[2] = 0; o[2] < EDGE; o[2] += NP_LEAF_EDGE) {
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, o);
        assert_non_null(leaf);
        for (int n = 0; n < NP_LEAF_SIZE; n++) {
          const int32_t at[3] = {o[0] + (n >> 6), o[1] + (n >> 3 & 7), o[2] + (n & 7)};
          if (!(get_slab(at) > 0.0f)) continue;
          leaf->values[n] = value(at);
          leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
        }
      }
}

/* `radius` NULL: no grid of radii. */
static void write_file(neph_context *context, const char *path, value_fn *density, const char *name, value_fn *radius) {
  np_sparse_grid grids[2] = {{0}};
  const np_vdb_write_grid outputs[] = {{.grid = &grids[0]}, {.grid = &grids[1]}};
  fill(context, "density", density, &grids[0]);
  if (radius) fill(context, name, radius, &grids[1]);
  assert_int_equal(np_volume_save_grids(context, path, outputs, radius ? 2 : 1, NULL), NEPH_OK);
  for (int i = 0; i < 2; i++) np_sparse_grid_clear(&grids[i]);
}

static void write_sizes(fixture *f, value_fn *radius) {
  write_file(f->context, f->path, get_slab, "effective_radius", radius);
}

/* ---- Scenes ---- */

/* The sun stands at 50° to the view: light is scattered by 130°. */
static const char lit[] =
    "version: 1\n"
    "environment: {planet: none, radiance: 0}\n"
    "camera: {position: [16 m, -160 m, 16 m], look_at: [16 m, 0 m, 16 m], fov: 10 deg, resolution: [16, 16]}\n"
    "sun: {elevation: 30 deg, azimuth: 215 deg}\n"
    "clouds: [{name: cloud, vdb: \"%s\", extinction: %s%s}]\n"
    "render: {integrator: %s, samples: %u%s}\n"
    "output: {color_space: bands}\n";

typedef struct look {
  const char *cloud, *render, *extinction;
  unsigned samples;
} look;

static neph_scene *load(fixture *f, const look *l, neph_integrator integrator) {
  char text[2048];
  (void)snprintf(text, sizeof text, lit, f->path, l->extinction ? l->extinction : "1 1/m", l->cloud ? l->cloud : "",
                 integrator == NEPH_INTEGRATOR_PATH ? "path" : "march", l->samples ? l->samples : 16,
                 l->render ? l->render : "");
  neph_scene *scene = NULL;
  if (neph_scene_load_text(f->context, text, "sizes.yaml", &scene)) fail_msg("%s", f->log.text);
  return scene;
}

static neph_image *render(fixture *f, neph_scene *scene) {
  neph_image *image = NULL;
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  neph_scene_destroy(scene);
  return image;
}

static neph_image *draw(fixture *f, const look *l, neph_integrator integrator) {
  return render(f, load(f, l, integrator));
}

static void assert_same(neph_image *a, neph_image *b) {
  assert_memory_equal(neph_image_get_channel(a, "G"), neph_image_get_channel(b, "G"), PIXELS * sizeof(float));
  assert_true(neph_image_get_channel(a, "G")[PIXELS / 2 + WIDTH / 2] > 0.0f);
  neph_image_destroy(a);
  neph_image_destroy(b);
}

/* Mean of two columns of pixels, which see 2 m of the cloud. */
static double get_columns(neph_image *image, int first) {
  const float *values = neph_image_get_channel(image, "G");
  double sum = 0.0;
  for (int y = 0; y < WIDTH; y++)
    for (int x = first; x < first + 2; x++) sum += (double)values[y * WIDTH + x];
  return sum / (2 * WIDTH);
}

static double get_mean(neph_image *image) {
  double sum = 0.0;
  for (int x = 0; x < WIDTH; x += 2) sum += get_columns(image, x) * 2 / WIDTH;
  return sum;
}

/* ---- The blend ---- */

typedef struct blend_error {
  double wide_angle, mean_cosine; /* largest relative error beyond 5°, and error of the mean cosine */
} blend_error;

/* Largest errors of the blends of all diameters between two. */
static blend_error measure_blend(double low_m, double high_m) {
  double nodes_m[NP_SIZE_NODES_MAX];
  const unsigned count = np_size_nodes_place(low_m, high_m, nodes_m);
  blend_error out = {0.0, 0.0};
  for (int i = 0; i <= 200; i++) {
    const double diameter_m = low_m * pow(high_m / low_m, i / 200.0);
    const np_phase exact = np_phase_droplets(diameter_m);
    float shares[NP_TINT_PARTS_MAX];
    double cosine = 0.0, sum = 0.0;
    np_size_nodes_share(nodes_m, count, diameter_m, shares);
    for (unsigned k = 0; k < count; k++) {
      const np_phase node = np_phase_droplets(nodes_m[k]);
      cosine += (double)shares[k] * np_phase_mean_cosine(&node);
      sum += (double)shares[k];
    }
    assert_near(sum, 1.0, 1e-6);
    out.mean_cosine = fmax(out.mean_cosine, fabs(cosine - np_phase_mean_cosine(&exact)));
    for (int angle = 5; angle <= 180; angle++) {
      const float versine = (float)(1.0 - cos(angle * NP_PI / 180.0));
      double blend = 0.0;
      for (unsigned k = 0; k < count; k++) {
        const np_phase node = np_phase_droplets(nodes_m[k]);
        blend += (double)(shares[k] * np_phase_eval(&node, versine));
      }
      out.wide_angle = fmax(out.wide_angle, fabs(blend / (double)np_phase_eval(&exact, versine) - 1.0));
    }
  }
  print_message("%.3g to %.3g um, %u nodes: beyond 5 deg %.2g, mean cosine %.2g\n", 1e6 * low_m, 1e6 * high_m, count,
                out.wide_angle, out.mean_cosine);
  return out;
}

/* The bounds are those that the documentation states. */
static void blends_are_near_the_phase_functions(void **state) {
  (void)state;
  const blend_error all = measure_blend(5e-6, 50e-6), usual = measure_blend(10e-6, 30e-6);
  assert_true(all.wide_angle < 0.043 && all.mean_cosine < 6e-4);
  assert_true(usual.wide_angle < 0.009 && usual.mean_cosine < 1e-4);
  const blend_error narrow = measure_blend(15e-6, 18e-6);
  assert_true(narrow.wide_angle < 0.005);
}

/* The parts are the density, and their mean place in 1/√d is the diameter's. */
static void parts_add_up(void **state) {
  fixture *f = *state;
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  np_tint *tint;
  load.precision = NEPH_PRECISION_FLOAT;
  write_sizes(f, get_slope);
  assert_int_equal(neph_volume_load(f->context, f->path, &load, &volume), NEPH_OK);
  const np_sizes_source source = {f->path, NULL, &load, volume, 20e-6};
  assert_int_equal(np_tint_create_sizes(f->context, &source, NULL, &tint), NEPH_OK);
  assert_int_equal(tint->count, NP_SIZE_NODES_MAX);
  assert_near(tint->parts[0].diameter_m, 10e-6, 1e-12);
  assert_near(tint->parts[3].diameter_m, 30e-6, 1e-12);
  for (int32_t n = 0; n < EDGE * EDGE * EDGE; n++) {
    const int32_t at[3] = {n >> 10, n >> 5 & 31, n & 31};
    const np_dvec3 index = np_dvec3_make(at[0], at[1], at[2]);
    double sum = 0.0, place = 0.0;
    for (unsigned k = 0; k < tint->count; k++) {
      const double own = (double)np_bricks_sample(&tint->parts[k].volume->bricks, index);
      sum += own;
      place += own / sqrt(tint->parts[k].diameter_m);
    }
    assert_near(sum, (double)get_slab(at), 1e-6);
    if (sum > 0.0) assert_near_relative(place / sum, 1.0 / sqrt(2e-6 * (double)get_slope(at)), 1e-3);
  }
  np_tint_destroy(tint);
  neph_volume_release(volume);
}

/* ---- Pictures ---- */

static const char *const methods[] = {"", ", multiple_scattering: octaves", ", max_scatterings: 1"};

/* The same bits: a cloud of one size is a cloud of that diameter, and a key leaves the file's sizes out. */
static void one_size_is_a_diameter(void **state) {
  fixture *f = *state;
  write_sizes(f, get_one);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++)
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
      if (i == NEPH_INTEGRATOR_PATH && m == 1) continue;
      const look sized = {.render = methods[m]};
      const look plain = {.cloud = ", phase: {droplets: {diameter: 15 um}}", .render = methods[m]};
      assert_same(draw(f, &sized, i), draw(f, &plain, i));
      const look left_out = {.cloud = ", phase: {droplets: {sizes: none}}", .render = methods[m]};
      const look usual = {.cloud = ", phase: {droplets: {diameter: 20 um}}", .render = methods[m]};
      assert_same(draw(f, &left_out, i), draw(f, &usual, i));
    }
}

/* A file whose halves have a size each is two files with a half each: the same bits. */
static void two_halves_are_two_clouds(void **state) {
  fixture *f = *state;
  char *left = test_path(f->folder, "left.vdb"), *right = test_path(f->folder, "right.vdb"), text[1024];
  write_sizes(f, get_halves);
  write_file(f->context, left, get_left, NULL, NULL);
  write_file(f->context, right, get_right, NULL, NULL);
  (void)snprintf(text, sizeof text,
                 "[{vdb: \"%s\", extinction: 1 1/m, phase: {droplets: {diameter: 10 um}}}, "
                 "{vdb: \"%s\", extinction: 1 1/m, phase: {droplets: {diameter: 40 um}}}]",
                 left, right);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    const look whole = {.cloud = ", phase: {droplets: {sizes: effective_radius}}"};
    neph_scene *scene = load(f, &whole, i);
    neph_image *image = draw(f, &whole, i);
    assert_int_equal(neph_scene_set(scene, "clouds", text), NEPH_OK);
    test_log_clear(&f->log);
    assert_same(image, render(f, scene));
  }
  free(left);
  free(right);
}

/* Light that is scattered once at 130° by droplets from 10 to 30 um: each pair of columns has the light of a cloud of
 * the columns' own diameter, and so in proportion to the phase functions. The march's steps are cut otherwise, 1 %;
 * the tracer's 32 pixels of 512 samples have noise of as much. */
static void light_scattered_once_has_the_size(void **state) {
  fixture *f = *state;
  write_sizes(f, get_slope);
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    const unsigned samples = i == NEPH_INTEGRATOR_PATH ? 512 : 16;
    const look sized = {.render = ", max_scatterings: 1", .extinction = "0.1 1/m", .samples = samples};
    neph_image *image = draw(f, &sized, i);
    for (int first = 2; first <= 12; first += 5) {
      char cloud[80];
      const double x_m = 16.0 + (first + 1 - 8) * 176.0 * 2.0 * tan(5.0 * NP_PI / 180.0) / WIDTH;
      const double diameter_um = 2.0 * (5.0 + 10.0 * (x_m - 2.0) / 27.0);
      (void)snprintf(cloud, sizeof cloud, ", phase: {droplets: {diameter: %g um}}", diameter_um);
      const look one = {.cloud = cloud, .render = ", max_scatterings: 1", .extinction = "0.1 1/m", .samples = samples};
      neph_image *plain = draw(f, &one, i);
      const double ratio = get_columns(image, first) / get_columns(plain, first);
      print_message("%s at %.3g um: %.4f\n", i == NEPH_INTEGRATOR_PATH ? "path" : "march", diameter_um, ratio);
      assert_near(ratio, 1.0, 0.02);
      neph_image_destroy(plain);
    }
    neph_image_destroy(image);
  }
}

/* Mean of a picture by the march over that by the tracer. */
static double compare_integrators(fixture *f, const char *cloud) {
  double mean[2];
  for (neph_integrator i = NEPH_INTEGRATOR_MARCH; i <= NEPH_INTEGRATOR_PATH; i++) {
    const look own = {.cloud = cloud, .samples = i == NEPH_INTEGRATOR_PATH ? 256 : 16};
    neph_image *image = draw(f, &own, i);
    mean[i == NEPH_INTEGRATOR_PATH] = get_mean(image);
    neph_image_destroy(image);
  }
  return mean[0] / mean[1];
}

/* Light in all orders: where the solution blends scaled phase functions, the march is as far from the tracer as it is
 * for droplets of one size in this slab of few voxels, to the tracer's noise of a percent. */
static void integrators_agree(void **state) {
  fixture *f = *state;
  write_sizes(f, get_slope);
  const double sized = compare_integrators(f, ", albedo: 0.99");
  const double one = compare_integrators(f, ", albedo: 0.99, phase: {droplets: {diameter: 20 um}}");
  print_message("march over path: %.4f, of one size %.4f\n", sized, one);
  assert_near(sized, one, 0.025);
}

/* A cloud that repeats has the same sizes in each period, of 29 voxels, of which eight are stored: to the bit, and
 * those of the file in the first. */
static void sizes_repeat(void **state) {
  enum { PERIOD = 29 };
  fixture *f = *state;
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  np_tint *tint;
  load.precision = NEPH_PRECISION_FLOAT;
  load.repeat_m[0] = load.repeat_m[1] = PERIOD;
  write_sizes(f, get_slope);
  assert_int_equal(neph_volume_load(f->context, f->path, &load, &volume), NEPH_OK);
  const np_sizes_source source = {f->path, NULL, &load, volume, 20e-6};
  assert_int_equal(np_tint_create_sizes(f->context, &source, NULL, &tint), NEPH_OK);
  for (int x = 0; x < PERIOD - 1; x++) {
    const int32_t at[3] = {x + 2, 15, 15};
    double sum = 0.0, place = 0.0;
    for (unsigned k = 0; k < tint->count; k++) {
      const np_bricks *bricks = &tint->parts[k].volume->bricks;
      const float own = np_bricks_sample(bricks, np_dvec3_make(x, 5, 15));
      for (int n = -9; n < 10; n++)
        assert_true(np_bricks_sample(bricks, np_dvec3_make(x + n * PERIOD, 5 - n * PERIOD, 15)) == own);
      sum += (double)own;
      place += (double)own / sqrt(tint->parts[k].diameter_m);
    }
    assert_near(sum, 0.25, 1e-6);
    assert_near_relative(place / sum, 1.0 / sqrt(2e-6 * (double)get_slope(at)), 1e-3);
  }
  np_tint_destroy(tint);
  neph_volume_release(volume);
}

/* ---- Names and values ---- */

static void files_that_cannot_be_meant_are_refused(void **state) {
  static const struct {
    value_fn *radius;
    const char *cloud, *message;
  } rows[] = {{get_metres, "", "must hold effective radii in um"},
              {get_hole, "", "grid 'effective_radius'"},
              {get_one, ", phase: {droplets: {sizes: radii}}", "no grid 'radii'"}};
  fixture *f = *state;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_image *image = NULL;
    write_sizes(f, rows[i].radius);
    neph_scene *scene = load(f, &(look){.cloud = rows[i].cloud}, NEPH_INTEGRATOR_MARCH);
    test_log_clear(&f->log);
    assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_BAD_FILE);
    if (!strstr(f->log.text, rows[i].message)) fail_msg("%s", f->log.text);
    neph_scene_destroy(scene);
  }
}

static void voxels_without_a_size_are_counted(void **state) {
  fixture *f = *state;
  write_sizes(f, get_gap);
  test_log_clear(&f->log);
  neph_image_destroy(draw(f, &(look){.render = ", max_scatterings: 1"}, NEPH_INTEGRATOR_MARCH));
  /* 2·12·28 of 28·12·28 voxels */
  if (!strstr(f->log.text, "672 of 9408 voxels of the cloud have no radius above 0")) fail_msg("%s", f->log.text);
}

/* ---- Failures ---- */

static neph_result attempt(neph_context *context, void *user) {
  neph_volume_load_desc load = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  np_tint *tint = NULL;
  neph_result result = neph_volume_load(context, user, &load, &volume);
  if (result) return result;
  const np_sizes_source source = {user, NULL, &load, volume, 20e-6};
  result = np_tint_create_sizes(context, &source, NULL, &tint);
  np_tint_destroy(tint);
  neph_volume_release(volume);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  fixture *f = *state;
  write_sizes(f, get_halves);
  assert_survives_failed_allocations(attempt, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blends_are_near_the_phase_functions),
      cmocka_unit_test_setup_teardown(parts_add_up, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(one_size_is_a_diameter, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(two_halves_are_two_clouds, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(light_scattered_once_has_the_size, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(integrators_agree, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(sizes_repeat, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(files_that_cannot_be_meant_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(voxels_without_a_size_are_counted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
