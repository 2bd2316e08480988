/* SPDX-License-Identifier: Apache-2.0 */
/* Deep, flat and stretched clouds in the solved multiple scattering: cells, memory and sweeps do not follow the depth,
 * light leaves a flat cloud by its thin side, and the stated error is that of the light. */
#include "test_lumpy.h"
#include "test_stability_page.h"

#include "core/context_private.h"

static test_page page;

/* ---- Work ---- */

static float get_full_ball(double x, double y, double z) { return x * x + y * y + z * z < 100.0 ? 1.0f : 0.0f; }

/* A ball of 20 voxels with a sharp rim, under a sun 53 degrees high: `depth` through its middle. */
static void create_ball(test_world *w, test_field field, double depth, np_dvec3 step_m) {
  const double across_m = 20.0 * fmin(step_m.x, fmin(step_m.y, step_m.z));
  const np_dvec3 half = np_dvec3_scale(step_m, 0.5 * (TEST_EDGE - 1));
  test_cloud cloud = test_cloud_make(field, (float)(depth / across_m), np_phase_henyey_greenstein(0.85f));
  cloud.step_m = step_m;
  test_world_create(w, 2, cloud);
  w->desc.cells.bounds_min = np_dvec3_scale(half, -1.0);
  w->desc.cells.bounds_max = half;
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
}

typedef struct work {
  size_t cells, bytes;
  unsigned sweeps;
  double error;
} work;

/* Solves on cells that start from two voxels, as those of files do. */
static work measure_work(double depth, np_dvec3 step_m) {
  test_world w;
  create_ball(&w, get_full_ball, depth, step_m);
  w.desc.cells.cell_count_cheap = 4000;
  const size_t before = w.context->allocated_bytes;
  test_lumpy_solve(&w);
  const work out = {w.scattering->grid.active_count, w.context->allocated_bytes_peak - before, w.scattering->sweeps,
                    w.scattering->quality.error};
  const double voxels[3] = {step_m.x, step_m.y, step_m.z};
  for (int a = 0; a < 3; a++) assert_true(w.scattering->grid.even_m[a] >= 0.5 * voxels[a]);
  assert_true(w.scattering->quality.residual <= w.desc.tolerance);
  test_world_destroy(&w);
  return out;
}

static void add_work(const char *name, const work *w) {
  test_page_add_figure(&page, "| %s | %zu | %.0f MB | %u | %.2g %% |", name, w->cells, 1e-6 * (double)w->bytes,
                       w->sweeps, 100.0 * w->error);
}

/* Depth alone takes cells of one voxel where those of two were enough, and no finer ones: eight times as many inside,
 * fewer at the rim. A long cloud takes no more than a ball, and a flat one lower cells while they are few. */
static void cells_do_not_follow_the_depth(void **state) {
  (void)state;
  static const double depths[] = {20.0, 100.0, 1e3, 1e4, 1e6};
  static const struct {
    const char *name;
    np_dvec3 step_m;
    size_t factor; /* most cells, over those of a ball */
  } shapes[] = {{"100 times as wide as high", {100.0, 100.0, 1.0}, 2},
                {"154 times as long as wide", {154.0, 1.0, 1.0}, 1}};
  test_page_add_figure(&page, "\n## Cells of deep and of stretched clouds\n");
  test_page_add_figure(&page, "| ball of 20 voxels | cells in cloud | memory | sweeps | expected error of cells |");
  test_page_add_figure(&page, "| --- | --- | --- | --- | --- |");
  work first = {0}, now;
  for (size_t n = 0; n < sizeof depths / sizeof *depths; n++) {
    char name[32];
    now = measure_work(depths[n], np_dvec3_make(1.0, 1.0, 1.0));
    if (n == 0) first = now;
    (void)snprintf(name, sizeof name, "depth %g", depths[n]);
    add_work(name, &now);
    assert_true(now.cells <= 8 * first.cells && now.bytes <= 8 * first.bytes);
    assert_true(now.sweeps <= 60);
  }
  for (size_t n = 0; n < sizeof shapes / sizeof *shapes; n++) {
    now = measure_work(20.0, shapes[n].step_m);
    add_work(shapes[n].name, &now);
    assert_true(now.cells >= first.cells && now.cells <= shapes[n].factor * first.cells && now.error <= 0.05);
  }
}

/* ---- Light ---- */

/* Irradiance that the middle of a plate sends up, over that of the sun on it. */
static double measure_reflectance(const test_world *w, double width_m) {
  enum { RAYS = 2000 };
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double sum = 0.0;
  for (int n = 0; n < RAYS; n++) {
    const float cosine = sqrtf(((float)n + 0.5f) / RAYS), sine = sqrtf(1.0f - cosine * cosine);
    const float azimuth = 2.0f * NP_PI_F * np_random_float(&random);
    const np_vec3 d = np_vec3_make(sine * cosf(azimuth), sine * sinf(azimuth), -cosine);
    const np_dvec3 at = np_dvec3_make(width_m * (np_random_double(&random) - 0.5),
                                      width_m * (np_random_double(&random) - 0.5), TEST_EDGE / 2.0);
    sum += test_lumpy_march(w, np_dvec3_along(at, d, -20.0), d, &random) / RAYS;
  }
  return NP_PI * sum / (double)w->world.to_sun.z;
}

/* A plate twenty times as wide as it is high and more reflects as a layer without end does
 * (tests/data/slab_albedo.csv), however wide its voxels are. 3 %: cells of two voxels, a twelfth of the plate. */
static void a_flat_cloud_reflects_as_a_layer(void **state) {
  (void)state;
  static const struct {
    double depth, cosine, reflectance;
  } layers[] = {{8.0, 1.0, 0.35843243}, {8.0, 0.5, 0.558077588}, {32.0, 1.0, 0.727807637}, {32.0, 0.5, 0.814021468}};
  static const double widths_m[] = {20.0, 100.0, 1000.0};
  for (size_t i = 0; i < sizeof layers / sizeof *layers; i++)
    for (size_t k = 0; k < sizeof widths_m / sizeof *widths_m; k++) {
      test_world w;
      create_ball(&w, test_full, layers[i].depth * 20.0 / TEST_EDGE, np_dvec3_make(widths_m[k], widths_m[k], 1.0));
      w.desc.cells.cell_count_cheap = 4000;
      w.world.to_sun =
          np_vec3_make((float)sqrt(1.0 - layers[i].cosine * layers[i].cosine), 0.0f, (float)layers[i].cosine);
      test_lumpy_solve(&w);
      const double found = measure_reflectance(&w, 8.0 * widths_m[k]);
      print_message("depth %g, sun %.2g, voxels %g m wide: %+.2f %%\n", layers[i].depth, layers[i].cosine, widths_m[k],
                    100.0 * (found / layers[i].reflectance - 1.0));
      assert_near_relative(found, layers[i].reflectance, 0.03);
      test_world_destroy(&w);
    }
}

/* Mean light of a ball seen from beside the sun, by march or by paths; with its standard error. */
static test_tally measure_light(const test_world *w, bool is_path, int rays) {
  test_tally out = {0};
  np_random random = np_random_start(5, 4, 3, 2, 1);
  for (int n = 0; n < rays; n++) {
    const double angle = NP_PI * (3.0 - sqrt(5.0)) * n, radius = 8.0 * sqrt((n + 0.5) / rays);
    const np_dvec3 origin = np_dvec3_make(radius * cos(angle), -60.0, radius * sin(angle));
    const np_camera_ray ray = {.origin = origin, .direction = {0, 1, 0}, .jitter = np_random_float(&random)};
    np_integrator_sample sample;
    (is_path ? test_world_path : test_world_march)(w, &ray, &random, &sample);
    test_tally_add(&out, test_sum_components(&sample, 0));
  }
  return out;
}

/* The light of deep balls is wrong by no more than their cells state, half as much again for pixels as
 * docs/error.md has it, and two standard errors as of independent rays, which even ones are well below. */
static void deep_cells_err_as_they_state(void **state) {
  (void)state;
  static const test_field fields[] = {get_full_ball, test_soft_ball};
  static const double depths[] = {100.0, 400.0, 1600.0};
  for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
    for (size_t k = 0; k < sizeof depths / sizeof *depths; k++) {
      test_world w;
      create_ball(&w, fields[i], depths[k], np_dvec3_make(1.0, 1.0, 1.0));
      w.desc.cells.cell_count_cheap = 4000;
      w.placed[0].albedo = np_spectrum_grey(0.999f);
      test_lumpy_solve(&w);
      const test_tally paths = measure_light(&w, true, 8000), march = measure_light(&w, false, 1000);
      const double expected = test_tally_mean(&paths), off = test_tally_mean(&march) / expected - 1.0;
      const double noise = hypot(test_tally_error(&paths), test_tally_error(&march)) / expected;
      print_message("depth %g: %+.1f ± %.1f %%, stated %.1f %%\n", depths[k], 100.0 * off, 100.0 * noise,
                    150.0 * w.scattering->quality.error);
      assert_true(fabs(off) <= 1.5 * w.scattering->quality.error + 2.0 * noise);
      test_world_destroy(&w);
    }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cells_do_not_follow_the_depth),
      cmocka_unit_test(a_flat_cloud_reflects_as_a_layer),
      cmocka_unit_test(deep_cells_err_as_they_state),
  };
  page = test_page_open(argc, argv);
  const int result = cmocka_run_group_tests(tests, NULL, NULL);
  test_page_close(&page);
  return result;
}
