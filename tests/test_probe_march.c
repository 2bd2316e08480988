/* SPDX-License-Identifier: Apache-2.0 */
/* The march against discrete ordinates (tests/data/slab_radiance.csv), adding-doubling (slab_albedo.csv) and the
 * asymptotic law of thick layers, through the probe.
 *
 * test_probe_march        a selection
 * test_probe_march long   every row; some minutes
 */
#include "test_probes.h"

static void probe(const fixture *f, unsigned path_count) {
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.integrator = NEPH_INTEGRATOR_MARCH;
  desc.path_count = path_count;
  run_probe(f, &desc);
}

static bool is_same_slab(const np_csv *csv, size_t a, size_t b) {
  static const char *const names[] = {"quantity", "g", "albedo", "tau", "mu0"};
  for (size_t n = 0; n < COUNT(names); n++) {
    const int column = np_csv_search_column(csv, names[n]);
    if (strcmp(np_csv_get_field(csv, a, column), np_csv_get_field(csv, b, column)) != 0) return false;
  }
  return true;
}

/* A radiance case is a slab and a side of it, and its mean that over |μ| of 0.1 and more and all azimuths; here each
 * azimuth for itself, which is more. 6 % is what is promised, 3 % what is aimed at; reached is 1 %. */
static void mean_radiances_are_within_three_percent(void **state) {
  const fixture *f = *state;
  static const pick picks[] = {{.phi_deg = "0"}, {.phi_deg = "60"}, {.phi_deg = "120"}, {.phi_deg = "180"}};
  write_cases(f, "data/slab_radiance.csv", picks, COUNT(picks));
  probe(f, 64);
  np_csv csv;
  double worst = 0.0;
  unsigned cases = 0;
  assert_int_equal(np_csv_load(f->context, f->answers, &csv), NEPH_OK);
  for (size_t row = 0, end; row < csv.row_count; row = end) {
    double expected = 0.0, actual = 0.0;
    for (end = row; end < csv.row_count && is_same_slab(&csv, row, end); end++) {
      if (fabs(get(&csv, end, "mu_view")) < 0.0999) continue;
      expected += get(&csv, end, "L");
      actual += get(&csv, end, "L_out");
    }
    assert_near_relative(actual, expected, 0.03);
    worst = fmax(worst, fabs(actual / expected - 1.0));
    cases++;
  }
  print_message("the worst of %u mean radiances %.2f %% off\n", cases, 100.0 * worst);
  assert_int_equal(cases, 4 * 2 * COUNT(picks));
  np_csv_clear(&csv);
}

/* `light` is what a relative error is taken of; three standard errors of the probe's own rays are left to chance. */
static double compute_error(const np_csv *csv, size_t row, const char *expected, const char *actual, const char *error,
                            double light) {
  const double off = fabs(get(csv, row, actual) - get(csv, row, expected)) - 3.0 * get(csv, row, error);
  return fmax(0.0, off) / light;
}

/* Promised are 6 % of what is reflected, and 10 % where the sun grazes a thin layer. */
static void assert_albedos(const fixture *f, unsigned count_min) {
  np_csv csv;
  double worst = 0.0;
  unsigned missed = 0;
  assert_int_equal(np_csv_load(f->context, f->answers, &csv), NEPH_OK);
  for (size_t row = 0; row < csv.row_count; row++) {
    const bool is_grazing = get(&csv, row, "mu0") <= 0.2 && get(&csv, row, "tau") <= 0.5;
    const double error = compute_error(&csv, row, "R", "R_out", "R_se", get(&csv, row, "R"));
    if (error > 0.05) print_message("%s: %.2g\n", csv.rows[row].text, error);
    missed += error > (is_grazing ? 0.1 : 0.06);
    worst = fmax(worst, error);
  }
  print_message("%zu slabs, the worst albedo %.2f %% off\n", csv.row_count, 100.0 * worst);
  assert_int_equal(missed, 0);
  assert_true(csv.row_count >= count_min);
  np_csv_clear(&csv);
}

static void albedos_are_within_six_percent(void **state) {
  static const pick picks[] = {
      {"0", "0.9", "1", "0.5", NULL, NULL},     {"0", "1", "0.1", "0.1", NULL, NULL},
      {"0", "1", "32", "1", NULL, NULL},        {"0.5", "0.99", "2", "0.2", NULL, NULL},
      {"0.75", "1", "0.5", "1", NULL, NULL},    {"0.85", "1", "0.1", "0.1", NULL, NULL},
      {"0.85", "1", "0.1", "1", NULL, NULL},    {"0.85", "1", "0.5", "0.5", NULL, NULL},
      {"0.85", "0.99", "1", "1", NULL, NULL},   {"0.85", "0.9", "1", "0.1", NULL, NULL},
      {"0.85", "1", "8", "0.5", NULL, NULL},    {"0.85", "0.99", "128", "1", NULL, NULL},
      {"0.9", "0.9", "0.1", "0.1", NULL, NULL}, {"0.9", "1", "0.1", "1", NULL, NULL},
      {"0.9", "0.9", "0.5", "1", NULL, NULL},   {"0.9", "1", "2", "1", NULL, NULL},
      {"0.9", "1", "128", "0.5", NULL, NULL},
  };
  write_cases(*state, "data/slab_albedo.csv", picks, COUNT(picks));
  probe(*state, 1000);
  assert_albedos(*state, COUNT(picks));
}

/* Transmission of a thick layer that absorbs nothing: T = (4/3)·K(μ0)/((1−g)·τ + 2q′), K and 2q′ of exact solutions
 * (van de Hulst 1980, "Multiple Light Scattering"). 1 % is what is promised, and three standard errors. */
static void assert_asymptotic_law(const fixture *f, unsigned path_count) {
  static const struct {
    const char *g, *mu0;
    double escape, twice_q;
  } laws[] = {{"0.85", "1", 1.2714, 1.4280},
              {"0.85", "0.5", 0.8687, 1.4280},
              {"0.85", "diffuse", 1.0, 1.4280},
              {"0", "diffuse", 1.0, 1.4209}};
  static const char *const depths[] = {"1e4", "1e6"};
  FILE *file = fopen(f->cases, "w");
  assert_non_null(file);
  fprintf(file, "quantity,g,albedo,tau,mu0\n");
  for (size_t d = 0; d < COUNT(depths); d++)
    for (size_t i = 0; i < COUNT(laws); i++) fprintf(file, "flux,%s,1,%s,%s\n", laws[i].g, depths[d], laws[i].mu0);
  fclose(file);
  probe(f, path_count);
  np_csv csv;
  assert_int_equal(np_csv_load(f->context, f->answers, &csv), NEPH_OK);
  for (size_t row = 0; row < csv.row_count; row++) {
    const size_t i = row % COUNT(laws);
    const double law =
        4.0 / 3.0 * laws[i].escape / ((1.0 - get(&csv, row, "g")) * get(&csv, row, "tau") + laws[i].twice_q);
    const double value = get(&csv, row, "T_out"), error = get(&csv, row, "T_se");
    print_message("g %s, tau %s, mu0 %s: T %+.2f +- %.2f %%\n", laws[i].g, np_csv_get_field(&csv, row, 3), laws[i].mu0,
                  100.0 * (value / law - 1.0), 100.0 * error / law);
    assert_near(value, law, 0.01 * law + 3.0 * error);
  }
  np_csv_clear(&csv);
}

static void thick_layers_follow_the_asymptotic_law(void **state) { assert_asymptotic_law(*state, 2000); }

/* Rays whose own error is a fifth of what is promised. */
static void thick_layers_follow_the_asymptotic_law_closely(void **state) { assert_asymptotic_law(*state, 20000); }

static void every_albedo_is_within_six_percent(void **state) {
  static const pick all = {0};
  write_cases(*state, "data/slab_albedo.csv", &all, 1);
  probe(*state, 4000);
  assert_albedos(*state, 420);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(mean_radiances_are_within_three_percent, set_up, tear_down),
      cmocka_unit_test_setup_teardown(albedos_are_within_six_percent, set_up, tear_down),
      cmocka_unit_test_setup_teardown(thick_layers_follow_the_asymptotic_law, set_up, tear_down),
  };
  const struct CMUnitTest long_tests[] = {
      cmocka_unit_test_setup_teardown(thick_layers_follow_the_asymptotic_law_closely, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_albedo_is_within_six_percent, set_up, tear_down),
  };
  const bool is_long = argc > 1 && strcmp(argv[1], "long") == 0;
  return is_long ? cmocka_run_group_tests(long_tests, NULL, NULL) : cmocka_run_group_tests(tests, NULL, NULL);
}
