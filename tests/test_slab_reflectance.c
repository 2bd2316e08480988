/* SPDX-License-Identifier: Apache-2.0 */
/* Reflectances of slabs against Chandrasekhar's H function and against paths. */
#include "test_support.h"

#include <stdlib.h>

#include <nephos/probe.h>

#include "optics/slab_reflectance.h"

static int set_up(void **state) { return test_set_up(state, 2, "cases.csv"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

static np_slab_table make_table(const test_fixture *f, const np_slab_view *view) {
  np_slab_table table;
  assert_int_equal(np_slab_table_make(f->context, view, &table), NEPH_OK);
  return table;
}

/* H of isotropic scattering: 1/H(μ) = √(1 − ω) + ω/2 ∫ x·H(x)/(μ + x) dx, iterated on midpoints. */
static void compute_h(double albedo, int count, double *h) {
  for (int i = 0; i < count; i++) h[i] = 1;
  for (int round = 0; round < 200; round++)
    for (int i = 0; i < count; i++) {
      const double mu = (i + 0.5) / count;
      double sum = 0;
      for (int k = 0; k < count; k++) {
        const double x = (k + 0.5) / count;
        sum += x * h[k] / (mu + x) / count;
      }
      h[i] = 1 / (sqrt(1 - albedo) + 0.5 * albedo * sum);
    }
}

/* A semi-infinite slab has the reflectance ω/4·H(μ)·H(μ₀)/(μ + μ₀); with an albedo of 0.9 a depth of 463 is infinite.
 * Midpoints of H err by 1e-4. */
static void a_deep_slab_has_the_reflectance_of_the_h_function(void **state) {
  enum { COUNT = 400 };
  static double h[COUNT];
  const np_phase isotropic = np_phase_isotropic();
  compute_h(0.9, COUNT, h);
  const int indices[3] = {100, 200, 399};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double mu = (indices[i] + 0.5) / COUNT, mu0 = (indices[j] + 0.5) / COUNT;
      const np_slab_view view = {&isotropic, 0.9, 0.0, mu0, mu, 1.0};
      const np_slab_table table = make_table(*state, &view);
      assert_near(table.reflectances[NP_SLAB_DEPTHS - 1], 0.25 * 0.9 * h[indices[i]] * h[indices[j]] / (mu + mu0),
                  3e-4);
    }
}

typedef struct slab_case {
  double g, albedo, depth, mu0, mu_view, phi_deg;
} slab_case;

/* Radiance of the integrator of paths, in units of the irradiance on the slab's plane, with its standard error. */
static double probe(const test_fixture *f, const slab_case *c, double *out_error) {
  FILE *file = fopen(f->path, "w");
  assert_non_null(file);
  fprintf(file, "quantity,g,albedo,tau,mu0,mu_view,phi_deg\nradiance_top_up,%g,%g,%g,%g,%g,%g\n", c->g, c->albedo,
          c->depth, c->mu0, c->mu_view, c->phi_deg);
  fclose(file);
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  char *text;
  double radiance;
  desc.path_count = 1 << 15;
  assert_int_equal(neph_probe_slab(f->context, f->path, &desc, &text), NEPH_OK);
  char *line = strrchr(text, '\n');
  if (!line[1]) *line = 0, line = strrchr(text, '\n');
  char *last = strrchr(line, ',');
  *out_error = atof(last + 1);
  *last = 0;
  radiance = atof(strrchr(line, ',') + 1);
  neph_text_destroy(f->context, text);
  return radiance;
}

/* Within four standard errors, and the table's own 1e-3. */
static void reflectances_are_those_of_paths(void **state) {
  static const slab_case cases[] = {{0.85, 1.0, 4, 0.5, 1.0, 0},     {0.85, 1.0, 20, 0.5, 1.0, 0},
                                    {0.75, 0.99, 2, 0.7, 0.6, 60},   {0.85, 1.0, 8, 0.5, 0.5, 0},
                                    {0.85, 1.0, 8, 0.5, 0.5, 180},   {0.0, 1.0, 1, 0.3, 0.8, 90},
                                    {0.85, 1.0, 0.5, 0.866, 1.0, 0}, {0.85, 1.0, 64, 0.5, 1.0, 0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const slab_case *c = &cases[i];
    const np_phase phase = np_phase_henyey_greenstein((float)c->g);
    /* phi is between directions of flight: light that goes on in the beam's azimuth is seen from the far side. */
    const np_slab_view view = {&phase, c->albedo, 0.0, c->mu0, c->mu_view, (180 - c->phi_deg) * NP_DEGREE};
    const np_slab_table table = make_table(*state, &view);
    double error;
    const double radiance = probe(*state, c, &error);
    assert_near(np_slab_table_eval(&table, c->depth), NP_PI * radiance, 4 * NP_PI * error + 1e-3);
  }
}

/* The ground shows through: under no cloud by its albedo, and under a conservative slab the plane's reflectance tends
 * to 1 for a white ground, in all directions. */
static void a_ground_adds_its_light(void **state) {
  const np_phase phase = np_phase_droplets(20e-6);
  const double angles[2] = {0.5, 1.0};
  for (int i = 0; i < 2; i++) {
    const np_slab_view view = {&phase, 1.0, 1.0, angles[i], 1.0, 0.0};
    const np_slab_table table = make_table(*state, &view);
    assert_near(table.reflectances[0], 1.0, 1e-12);
    assert_near(table.reflectances[1], 1.0, 0.02);
    const np_slab_view dark = {&phase, 1.0, 0.0, angles[i], 1.0, 0.0};
    const np_slab_table below = make_table(*state, &dark);
    for (int k = 1; k < NP_SLAB_DEPTHS; k++) assert_true(table.reflectances[k] > below.reflectances[k]);
  }
}

static void a_depth_comes_back_from_its_reflectance(void **state) {
  const np_phase phase = np_phase_henyey_greenstein(0.85f);
  const np_slab_view view = {&phase, 1.0, 0.1, 0.5, 1.0, 0.0};
  const np_slab_table table = make_table(*state, &view);
  for (double depth = 0.01; depth < 300; depth *= 1.7)
    assert_near(np_slab_table_invert(&table, np_slab_table_eval(&table, depth)), depth, 1e-9 * depth);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(a_deep_slab_has_the_reflectance_of_the_h_function),
                                     TEST(reflectances_are_those_of_paths), TEST(a_ground_adds_its_light),
                                     TEST(a_depth_comes_back_from_its_reflectance)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
