/* SPDX-License-Identifier: Apache-2.0 */
/* The solution of thick clouds has converged where its residual says so. */
#include "core/half.h"
#include "test_world.h"
#include "transport/scattering_field_private.h"

enum { EDGE = 36 }; /* 46,656 cells of one voxel: too many to be driven to the end of floats */

/* Lumps with clefts between them, 0 on the faces of the box. */
static float lumps(double x, double y, double z) {
  const double k = NP_PI / (EDGE - 1), window = cos(k * x) * cos(k * y) * cos(k * z);
  const double lump = sin(0.9 * x) * sin(0.7 * y + 1.0) * sin(0.8 * z);
  return (float)(fmax(window, 0.0) * fmax(0.3 + lump, 0.0));
}

/* `depth`: of the densest voxel times the edge, some three times that of the deepest column. */
static void start(test_world *w, unsigned threads, double depth) {
  test_cloud cloud = test_cloud_make(lumps, (float)(depth / EDGE), np_phase_henyey_greenstein(0.85f));
  cloud.edge = EDGE;
  test_world_create(w, threads, cloud);
  const double half = 0.5 * EDGE;
  w->desc.cells.bounds_min = np_dvec3_make(-half, -half, -half);
  w->desc.cells.bounds_max = np_dvec3_make(half, half, half);
  w->desc.cells.cell_count_cheap = 1000000;
  w->desc.work_max = 0.0;
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
}

static void solve(test_world *w, double tolerance) {
  np_scattering_field_destroy(w->scattering);
  w->scattering = NULL;
  w->desc.tolerance = tolerance;
  assert_int_equal(test_world_solve(w), NEPH_OK);
}

/* First moments of a band, which are mean radiances but for a factor. */
static float *copy_band(const np_scattering_field *field, unsigned band) {
  float *out = malloc(field->grid.active_count * sizeof *out), moments[NP_HARMONIC_COUNT_MAX];
  for (size_t i = 0; i < field->grid.active_count; i++) {
    np_scattering_field_read_band(field, i, band, moments);
    out[i] = moments[0];
  }
  return out;
}

static double compute_difference(const float *a, const float *b, size_t count) {
  double squares = 0.0, all = 0.0;
  for (size_t i = 0; i < count; i++) {
    squares += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
    all += (double)b[i] * (double)b[i];
  }
  return sqrt(squares / all);
}

/* The field at the default residual, 3e-4, is within 1e-3 of one with a residual of a hundredth, at any depth. Without
 * the correction the error is 1 % at a depth of 110, and 10 % at 1000. Rounding to halves adds 2e-4. Sweeps are counted
 * on the last grid, where plain Anderson acceleration needs up to 17. */
static void a_small_residual_is_a_small_error(void **state) {
  (void)state;
  static const double depths[] = {110.0, 1000.0};
  static const unsigned sweeps_max[] = {8, 10};
  for (size_t d = 0; d < sizeof depths / sizeof *depths; d++) {
    test_world w;
    start(&w, 2, depths[d]);
    solve(&w, 3e-6);
    float *converged = copy_band(w.scattering, 0);
    solve(&w, 3e-4);
    float *means = copy_band(w.scattering, 0);
    const double error = compute_difference(means, converged, w.scattering->grid.active_count);
    print_message("depth %g: residual %.2g, %u sweeps, error %.2g\n", depths[d], w.scattering->quality.residual,
                  w.scattering->sweeps, error);
    assert_true(w.scattering->quality.residual <= 3e-4);
    assert_true(error <= 1e-3);
    assert_true(w.scattering->sweeps <= sweeps_max[d]);
    free(means);
    free(converged);
    test_world_destroy(&w);
  }
}

static void threads_change_no_bit(void **state) {
  (void)state;
  float *means[2];
  size_t count = 0;
  for (unsigned threads = 1; threads <= 2; threads++) {
    test_world w;
    start(&w, threads, 300.0);
    solve(&w, 3e-3);
    means[threads - 1] = copy_band(w.scattering, 0);
    count = w.scattering->grid.active_count;
    test_world_destroy(&w);
  }
  assert_memory_equal(means[0], means[1], count * sizeof(float));
  free(means[0]);
  free(means[1]);
}

static void colour(test_world *w, np_spectrum sun) {
  w->world.sun_irradiance = sun;
  w->world.environment_radiance = (np_spectrum){{0.02f, 0.04f, 0.09f}};
  w->desc.cells.cell_count_max = 1000000;
}

/* The first band is solved, and others derive from it where the sun makes up most of the light; importance needs each
 * band separately. The sky is a quarter of the light in the bluest band. */
static void assert_transfer(np_spectrum sun, double error_max) {
  test_world w;
  float *bands[2][NP_BAND_COUNT];
  start(&w, 2, 110.0);
  colour(&w, sun);
  for (int i = 0; i < 2; i++) {
    w.desc.has_importance = i;
    solve(&w, 3e-3); /* both from the same moments */
    assert_int_equal(w.scattering->grid.degree, 7);
    assert_int_equal(w.scattering->medium.band_count, NP_BAND_COUNT);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) bands[i][b] = copy_band(w.scattering, b);
  }
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    const double error = compute_difference(bands[0][b], bands[1][b], w.scattering->grid.active_count);
    print_message("band %u: %.2g from one that is resolved for itself\n", b, error);
    assert_true(error <= error_max);
    for (int i = 0; i < 2; i++) free(bands[i][b]);
  }
  test_world_destroy(&w);
}

static void bands_share_what_resolving_changes(void **state) {
  (void)state;
  assert_transfer((np_spectrum){{1.0f, 0.95f, 0.85f}}, 2e-3);
}

/* Little sun: nothing is shared, and the bits are those of bands for themselves. */
static void bands_of_little_sun_share_nothing(void **state) {
  (void)state;
  assert_transfer((np_spectrum){{0.05f, 0.03f, 0.01f}}, 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_small_residual_is_a_small_error),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(bands_share_what_resolving_changes),
      cmocka_unit_test(bands_of_little_sun_share_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
