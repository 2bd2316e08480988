/* SPDX-License-Identifier: Apache-2.0 */
/* Transmittance, order 1 and irradiance of one Earth: against a published code, and with themselves. */
#include "test_skies.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/sky_reference.h"

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
static void describe_reference(test_air *air) {
  const double rayleigh[3] = {5.802339382e-6, 13.55776245e-6, 33.10000598e-6};
  const double ozone[3] = {0.6497166e-6, 1.8809e-6, 0.08501668e-6};
  test_air_start(air);
  test_air_set_one_lobe(air);
  test_air_set_albedo(air, 0.1);
  air->desc.top_altitude_m = 60000.0;
  memcpy(air->layers[TEST_MOLECULES].scattering_per_m, rayleigh, sizeof rayleigh);
  memcpy(air->layers[TEST_OZONE].absorption_per_m, ozone, sizeof ozone);
}

static const double reference_sun[3] = {1.474, 1.8504, 1.91198};

static int create_reference(void **state) {
  test_air air;
  describe_reference(&air);
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *atmosphere = test_atmosphere_create(context, &air.desc);
  atmosphere->has_point_sun = true; /* like the reference */
  *state = atmosphere;
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
  const np_sky_light light = {.kernels = np_fan_get_kernels(a->context->isa),
                              .medium = &a->medium,
                              .depths = &a->depths,
                              .disk = np_sun_disk_make(0.2678 * NP_DEGREE, true)};
  const np_path_rule rule = np_path_rule_make(points);
  const np_ray ray = np_ray_make(&a->medium, altitude_m, view_cosine);
  np_path path;
  np_path_build(&a->medium, &ray, &rule, &path);
  const np_fan fan = np_fan_make_single(&ray, (float)sun_cosine, (float)angle_cosine);
  np_scattered s;
  np_sky_trace(&light, &fan, &path, &s);
  return s.smooth + np_aerosol_phase(&a->medium, 1.0f - (float)angle_cosine) * s.peak;
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

/* The reference is good to 0.055 % for a sun above the horizon; 0.5 % is this stage's gate for the path the sky view
 * uses. */
static void first_order_agrees_with_reference(void **state) {
  const int points[] = {32, 64};
  for (int i = 0; i < 2; i++) {
    first_order_check c = {*state, points[i], 0.005, 0.0};
    for_each_row("single_scatter_radiance", NULL, check_first_order, &c);
    print_message("order 1, %d points a ray, sun up: worst relative error %.3f %%\n", points[i], 100.0 * c.worst);
  }
}

/* ---- Irradiance ---- */

/* The reference's sky irradiance is good to about 3 %, by its own header, and stops after four orders, which leaves
 * out 2.7 % of the blue, more under a low sun: 6 %. The sun's is good to its tables' 1e-3, where the sun is clear of
 * the horizon, and ours to 5e-3. */
static void check_sky_irradiance(const reference_row *row, void *user) {
  const neph_atmosphere *atmosphere = user;
  if (row->sun_deg > 80.0) return;
  const np_spectrum sky = np_atmosphere_ground_irradiance(atmosphere, 0.0, (float)cos(row->sun_deg * NP_DEGREE));
  for (int i = 0; i < 3; i++) assert_near_relative((double)sky.band[i] * reference_sun[i], row->value[i], 0.06);
}

static void check_sun_irradiance(const reference_row *row, void *user) {
  const neph_atmosphere *atmosphere = user;
  if (row->sun_deg > 88.0) return;
  const double sun = row->sun_deg * NP_DEGREE;
  const np_spectrum t = np_atmosphere_transmittance_to_sun(
      atmosphere, np_dvec3_make(0, 0, 0), np_vec3_make((float)sin(sun), 0.0f, (float)cos(sun)), 0.00467396f);
  for (int i = 0; i < 3; i++)
    assert_near_relative((double)t.band[i] * reference_sun[i] * cos(sun), row->value[i], 0.005);
}

static void irradiance_agrees_with_reference(void **state) {
  for_each_row("sky_irradiance", NULL, check_sky_irradiance, *state);
  for_each_row("direct_irradiance", NULL, check_sun_irradiance, *state);
}

/* ---- Between points ---- */

/* Transmittance to a point times that on to space is that to space: 1e-5, the rounding of float transmittances. */
static void transmittances_multiply(void **state) {
  const neph_atmosphere *atmosphere = *state;
  const np_dvec3 from = np_dvec3_make(3000.0, -2000.0, 1200.0);
  const np_vec3 direction = np_vec3_normalize(np_vec3_make(0.6f, 0.5f, 0.3f));
  const np_dvec3 middle = np_dvec3_along(from, direction, 7000.0);
  double whole[3], rest[3];
  const double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
  const double from_m[3] = {from.x, from.y, from.z}, middle_m[3] = {middle.x, middle.y, middle.z};
  neph_atmosphere_get_transmittance(atmosphere, from_m, d, whole);
  neph_atmosphere_get_transmittance(atmosphere, middle_m, d, rest);
  const np_spectrum part = np_atmosphere_transmittance_between(atmosphere, from, middle);
  const np_spectrum back = np_atmosphere_transmittance_between(atmosphere, middle, from);
  for (int i = 0; i < 3; i++) {
    assert_near_relative((double)part.band[i] * rest[i], whole[i], 1e-5);
    assert_near_relative((double)back.band[i], (double)part.band[i], 1e-5);
  }
}

/* Straight up and down, along the limb, in space, and behind the planet. */
static void transmittance_knows_where_the_planet_is(void **state) {
  const neph_atmosphere *atmosphere = *state;
  const np_vec3 up = np_vec3_make(0, 0, 1), down = np_vec3_make(0, 0, -1), level = np_vec3_make(1, 0, 0);
  const np_dvec3 ground = np_dvec3_make(0, 0, 0), space = np_dvec3_make(0, 0, 1e6),
                 behind = np_dvec3_make(-3e7, 0, -6360e3);
  assert_true(np_atmosphere_transmittance_to_space(atmosphere, ground, up).band[0] > 0.9f);
  assert_near((double)np_atmosphere_transmittance_to_space(atmosphere, ground, down).band[0], 0.0, 0.0);
  assert_near((double)np_atmosphere_transmittance_to_space(atmosphere, space, level).band[0], 1.0, 0.0);
  assert_near((double)np_atmosphere_transmittance_to_space(atmosphere, space, down).band[0], 0.0, 0.0);
  assert_near((double)np_atmosphere_transmittance_to_sun(atmosphere, behind, level, 0.005f).band[0], 0.0, 0.0);
  assert_near((double)np_atmosphere_transmittance_between(atmosphere, space, np_dvec3_make(9e6, 0, 1e6)).band[2], 1.0,
              0.0);
  assert_near((double)np_atmosphere_transmittance_between(atmosphere, ground, ground).band[2], 1.0, 0.0);
}

/* Two rays for the whole disk against eight for its visible part, from the disk's upper edge at the horizon to two
 * degrees above it, low and high: 2 % where it is seen whole, of a full sun's light where it sets. */
static void disk_shines_through_the_air(void **state) {
  neph_atmosphere *atmosphere = *state;
  atmosphere->has_point_sun = false;
  const double heights[] = {0.0, 10e3, 40e3};
  for (int i = 0; i < 3; i++)
    for (double above = -1.0; above < 8.0; above += 0.25) {
      const double zenith = np_horizon_angle(&atmosphere->medium, heights[i], 0.0) - above * 0.00467396;
      const np_dvec3 sun = np_dvec3_make(sin(zenith), 0.0, cos(zenith)), position = np_dvec3_make(0, 0, heights[i]);
      const np_reference_scene scene = {.medium = &atmosphere->medium,
                                        .light = NP_REFERENCE_DISK,
                                        .to_sun = sun,
                                        .sun_angular_radius_rad = 0.00467396};
      double exact[3];
      np_reference_sunlight(&scene, position, exact);
      const np_spectrum light =
          np_atmosphere_transmittance_to_sun(atmosphere, position, np_dvec3_to_float(sun), 0.00467396f);
      for (int b = 0; b < 3; b++)
        assert_near((double)light.band[b], exact[b], above < 1.0 ? 0.02 : 0.02 * exact[b] + 1e-4);
    }
  atmosphere->has_point_sun = true;
}

/* A disk on the horizon is halved, not switched: half, by symmetry of the cubic, to 2 % for the slope of the depth. */
static void sun_sets_over_its_width(void **state) {
  const np_dvec3 sea = np_dvec3_make(0, 0, 0);
  const np_vec3 level = np_vec3_make(1, 0, 0);
  const double full = (double)np_atmosphere_transmittance_to_space(*state, sea, level).band[0];
  assert_near((double)np_atmosphere_transmittance_to_sun(*state, sea, level, 0.005f).band[0], 0.5 * full, 0.02 * full);
  const np_vec3 set = np_vec3_normalize(np_vec3_make(1, 0, -0.0051f));
  assert_near((double)np_atmosphere_transmittance_to_sun(*state, sea, set, 0.005f).band[0], 0.0, 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(integrated_transmittance_agrees_with_reference),
      cmocka_unit_test(table_of_depths_agrees_with_reference),
      cmocka_unit_test(first_order_agrees_with_reference),
      cmocka_unit_test(irradiance_agrees_with_reference),
      cmocka_unit_test(transmittances_multiply),
      cmocka_unit_test(transmittance_knows_where_the_planet_is),
      cmocka_unit_test(sun_sets_over_its_width),
      cmocka_unit_test(disk_shines_through_the_air),
  };
  return cmocka_run_group_tests(tests, create_reference, release_reference);
}
