/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"

/* ---- Reference rows ---- */

/* A row of tests/data/atmosphere.csv; its header says what each column is. */
typedef struct reference_row {
  char quantity[32], method[48];
  double altitude_m, cosine, sun_deg, view_deg, azimuth_deg;
  double value[3];
} reference_row;

/* The next field of a comma-separated line, empty ones included; the commas become ends. */
static const char *next_field(char **line) {
  char *field = strsep(line, ",\n");
  return field ? field : "";
}

static bool parse_row(char *line, reference_row *out) {
  const char *quantity = next_field(&line), *earth = next_field(&line);
  if (strcmp(earth, "bruneton") != 0) return false;
  snprintf(out->quantity, sizeof out->quantity, "%s", quantity);
  next_field(&line);
  out->altitude_m = NP_KILOMETRE * strtod(next_field(&line), NULL);
  out->cosine = strtod(next_field(&line), NULL);
  out->sun_deg = strtod(next_field(&line), NULL);
  out->view_deg = strtod(next_field(&line), NULL);
  out->azimuth_deg = strtod(next_field(&line), NULL);
  next_field(&line);
  for (int i = 0; i < 3; i++) out->value[i] = strtod(next_field(&line), NULL);
  snprintf(out->method, sizeof out->method, "%s", next_field(&line));
  return true;
}

/* Calls `check` for every row of one quantity and, unless NULL, one method; there must be some. */
static void for_each_row(const char *quantity, const char *method, void (*check)(const reference_row *, void *),
                         void *user) {
  FILE *file = fopen(NEPHOS_TEST_SOURCE_DIR "/data/atmosphere.csv", "r");
  assert_non_null(file);
  char line[1024];
  unsigned count = 0;
  while (fgets(line, sizeof line, file)) {
    reference_row row;
    if (line[0] == '#' || !parse_row(line, &row) || strcmp(row.quantity, quantity) != 0) continue;
    if (method && strcmp(row.method, method) != 0) continue;
    check(&row, user);
    count++;
  }
  fclose(file);
  assert_true(count > 0);
}

/* The Earth of those rows: 60 km of air, ozone and Rayleigh to the last digit given there. */
static neph_atmosphere_desc reference_earth(void) {
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  const double rayleigh[3] = {5.802339382e-6, 13.55776245e-6, 33.10000598e-6};
  const double ozone[3] = {0.6497166e-6, 1.8809e-6, 0.08501668e-6};
  desc.top_altitude_m = 60000.0;
  for (int i = 0; i < 3; i++) {
    desc.rayleigh_scattering_per_m[i] = rayleigh[i];
    desc.ozone_absorption_per_m[i] = ozone[i];
    desc.ground_albedo[i] = 0.1;
  }
  return desc;
}

static const double reference_sun[3] = {1.474, 1.8504, 1.91198};

static neph_atmosphere *create_atmosphere(neph_context *context, const neph_atmosphere_desc *desc) {
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, desc, &atmosphere), NEPH_OK);
  return atmosphere;
}

static int create_reference(void **state) {
  const neph_atmosphere_desc desc = reference_earth();
  neph_context *context = test_context_create(1, NULL);
  *state = create_atmosphere(context, &desc);
  neph_context_destroy(context);
  return 0;
}

static int release_reference(void **state) {
  neph_atmosphere_release(*state);
  return 0;
}

/* ---- Transmittance ---- */

typedef struct worst {
  const neph_atmosphere *atmosphere;
  double value;
} worst;

static void check_integrated_transmittance(const reference_row *row, void *user) {
  worst *w = user;
  const double position[3] = {0.0, 0.0, row->altitude_m};
  const double direction[3] = {sqrt(1.0 - row->cosine * row->cosine), 0.0, row->cosine};
  double transmittance[3];
  neph_atmosphere_get_transmittance(w->atmosphere, position, direction, transmittance);
  for (int i = 0; i < 3; i++) {
    /* Relative: the reference is good to 1e-7. */
    w->value = fmax(w->value, fabs(transmittance[i] / row->value[i] - 1.0));
    assert_near_relative(transmittance[i], row->value[i], 1e-4);
  }
}

static void integrated_transmittance_agrees_with_reference(void **state) {
  worst w = {*state, 0.0};
  for_each_row("transmittance_top", "n200000_trapezoid", check_integrated_transmittance, &w);
  print_message("transmittance by quadrature: worst relative error %.1e\n", w.value);
}

static void check_table_depth(const reference_row *row, void *user) {
  worst *w = user;
  const np_depth_row at = np_depth_table_row(&w->atmosphere->depths, row->altitude_m);
  const np_bands depth = np_depth_row_lookup(&at, (float)row->cosine);
  for (int i = 0; i < 3; i++) {
    const double expected = -log(row->value[i]);
    w->value = fmax(w->value, fabs((double)depth[i] / expected - 1.0));
    assert_near_relative((double)depth[i], expected, 1e-3);
  }
}

static void table_of_depths_agrees_with_reference(void **state) {
  worst w = {*state, 0.0};
  for_each_row("transmittance_top", "n200000_trapezoid", check_table_depth, &w);
  print_message("optical depth by table: worst relative error %.1e\n", w.value);
}

/* ---- Order 1 ---- */

static np_bands trace_first_order(const neph_atmosphere *a, double altitude_m, double view_cosine, double sun_cosine,
                                  double angle_cosine, int points) {
  const np_sky_light light = {&a->medium, &a->depths, NULL, NULL, np_sun_inverse_diameter(0.2678 * NP_DEGREE)};
  const np_path_rule rule = np_path_rule_make(points);
  const np_ray ray = np_ray_make(&a->medium, altitude_m, view_cosine);
  np_path path;
  np_sky_node nodes[NP_PATH_MAX];
  np_path_build(&a->medium, &ray, &rule, &path);
  for (int i = 0; i < path.count; i++) np_sky_node_resolve(&light, &path.node[i], &nodes[i]);
  const np_scattered s =
      np_sky_trace(&light, &ray, &path, nodes, (float)sun_cosine, (float)angle_cosine, false);
  return s.smooth + np_phase_eval(&a->medium.mie_phase, 1.0f - (float)angle_cosine) * s.peak;
}

typedef struct first_order_check {
  const neph_atmosphere *atmosphere;
  int points;
  double tolerance, worst;
} first_order_check;

static void check_first_order(const reference_row *row, void *user) {
  first_order_check *c = user;
  if (row->sun_deg > 90.0) return;
  const double view = row->view_deg * NP_DEGREE, sun = row->sun_deg * NP_DEGREE;
  const double angle = cos(view) * cos(sun) + sin(view) * sin(sun) * cos(row->azimuth_deg * NP_DEGREE);
  const np_bands light = trace_first_order(c->atmosphere, row->altitude_m, cos(view), cos(sun), angle, c->points);
  for (int i = 0; i < 3; i++) {
    const double value = (double)light[i] * reference_sun[i];
    c->worst = fmax(c->worst, fabs(value / row->value[i] - 1.0));
    assert_near_relative(value, row->value[i], c->tolerance);
  }
}

/* The reference is good to 0.055 % for a sun above the horizon; 0.5 % is this stage's gate for the path the sky view uses. */
static void first_order_agrees_with_reference(void **state) {
  const int points[] = {32, 64};
  for (int i = 0; i < 2; i++) {
    first_order_check c = {*state, points[i], 0.005, 0.0};
    for_each_row("single_scatter_radiance", NULL, check_first_order, &c);
    print_message("order 1, %d points a ray, sun up: worst relative error %.3f %%\n", points[i], 100.0 * c.worst);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(integrated_transmittance_agrees_with_reference),
      cmocka_unit_test(table_of_depths_agrees_with_reference),
      cmocka_unit_test(first_order_agrees_with_reference),
  };
  return cmocka_run_group_tests(tests, create_reference, release_reference);
}
