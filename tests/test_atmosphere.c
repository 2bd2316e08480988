/* SPDX-License-Identifier: Apache-2.0 */
#include "test_skies.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/sky_truth.h"

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
  atmosphere->has_point_sun = true; /* as the reference has it */
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
  const np_sky_light light = {&a->medium, &a->depths, NULL, NULL, np_sun_disk_make(0.2678 * NP_DEGREE, true)};
  const np_path_rule rule = np_path_rule_make(points);
  const np_ray ray = np_ray_make(&a->medium, altitude_m, view_cosine);
  np_path path;
  np_sky_node nodes[NP_PATH_MAX];
  np_path_build(&a->medium, &ray, &rule, &path);
  for (int i = 0; i < path.count; i++) np_sky_node_resolve(&light, &path.node[i], &nodes[i]);
  const np_scattered s = np_sky_trace(&light, &ray, &path, nodes, (float)sun_cosine, (float)angle_cosine, false);
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
  const np_spectrum sky = np_atmosphere_ground_irradiance(atmosphere, (float)cos(row->sun_deg * NP_DEGREE));
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

/* To a point and on to space is to space: 1e-5, the rounding of float transmittances. */
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
      const np_truth_scene scene = {
          .medium = &atmosphere->medium, .light = NP_TRUTH_DISK, .to_sun = sun, .sun_angular_radius_rad = 0.00467396};
      double exact[3];
      np_truth_sunlight(&scene, position, exact);
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

/* ---- Airs ---- */

static const double smoke_altitude[4] = {3500.0, 4000.0, 4600.0, 5000.0}, smoke_density[4] = {0.0, 1.0, 0.8, 0.0};

/* The Earth with a table of smoke, a tent of dust with a backward lobe, and fog that ends at 300 m. */
static void describe_layered(test_air *air) {
  test_air_start(air);
  air->layers[3] = (neph_atmosphere_layer){.profile = NEPH_LAYER_TABLE,
                                           .top_m = (double)INFINITY,
                                           .table_altitude_m = smoke_altitude,
                                           .table_density = smoke_density,
                                           .table_rows = 4,
                                           .scattering_per_m = {20e-6, 25e-6, 30e-6},
                                           .absorption_per_m = {4e-6, 4e-6, 4e-6},
                                           .phase = NEPH_LAYER_HENYEY_GREENSTEIN,
                                           .asymmetry = {0.6, 0.6, 0.6}};
  air->layers[4] = (neph_atmosphere_layer){.profile = NEPH_LAYER_TENT,
                                           .top_m = (double)INFINITY,
                                           .center_m = 20000.0,
                                           .width_m = 3000.0,
                                           .scattering_per_m = {2e-6, 2e-6, 2e-6},
                                           .phase = NEPH_LAYER_TWO_LOBE,
                                           .asymmetry = {0.8, 0.8, 0.8},
                                           .second_asymmetry = {-0.4, -0.4, -0.4},
                                           .second_weight = {0.2, 0.2, 0.2}};
  air->layers[5] = air->layers[TEST_AEROSOL];
  air->layers[5].top_m = 300.0;
  test_air_scale(air, 5, 50.0);
  air->desc.layer_count = 6;
}

/* ---- Extremes ---- */

/* Looks everywhere from several altitudes under several suns: all finite, nothing negative, no transmittance above 1.
 */
static void assert_sane(const neph_atmosphere_desc *desc) {
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *atmosphere = test_atmosphere_create(context, desc);
  const double suns[] = {1.0, 0.05, -0.1, 0.5}, heights[] = {0.0, 0.02, 3.0, -0.05};
  for (int i = 0; i < 4; i++) {
    neph_sky_desc sky_desc = NEPH_SKY_DESC_DEFAULT;
    sky_desc.sun_direction[0] = sqrt(1.0 - suns[i] * suns[i]);
    sky_desc.sun_direction[2] = suns[i];
    sky_desc.observer_m[2] = heights[i] * desc->top_altitude_m;
    neph_sky *sky = NULL;
    assert_int_equal(neph_sky_create(atmosphere, &sky_desc, &sky), NEPH_OK);
    for (int zenith = 0; zenith <= 180; zenith += 2) {
      const double angle = zenith * NP_DEGREE, direction[3] = {sin(angle), 0.0, cos(angle)};
      double light[3], transmittance[3], inscatter[3];
      neph_sky_get_radiance(sky, direction, light);
      neph_sky_get_aerial_perspective(sky, direction, 0.3 * desc->top_altitude_m, transmittance, inscatter);
      for (int b = 0; b < 3; b++) {
        assert_true(isfinite(light[b]) && light[b] >= 0.0 && isfinite(inscatter[b]) && inscatter[b] >= 0.0);
        assert_true(transmittance[b] >= 0.0 && transmittance[b] <= 1.0);
      }
    }
    neph_sky_destroy(sky);
  }
  neph_atmosphere_release(atmosphere);
  neph_context_destroy(context);
}

static void planets_of_all_sizes_have_a_sky(void **state) {
  (void)state;
  const double radii[] = {100e3, 1000e3, 100000e3};
  for (int i = 0; i < 3; i++) {
    neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
    desc.planet_radius_m = radii[i];
    assert_sane(&desc);
  }
}

static void scale_air(test_air *air, double rayleigh, double mie, double ozone, double albedo) {
  test_air_start(air);
  test_air_scale(air, TEST_MOLECULES, rayleigh);
  test_air_scale(air, TEST_AEROSOL, mie);
  test_air_scale(air, TEST_OZONE, ozone);
  test_air_set_albedo(air, albedo);
}

static void thick_and_absent_air_have_a_sky(void **state) {
  (void)state;
  const double factors[][4] = {{100, 100, 100, 1.0}, {0, 1, 1, 0.0}, {1, 0, 0, 0.3}, {0, 0, 1, 1.0}, {0, 200, 0, 0.5}};
  for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
    test_air air;
    scale_air(&air, factors[i][0], factors[i][1], factors[i][2], factors[i][3]);
    for (int b = 0; b < 3 && i == 4; b++) air.layers[TEST_AEROSOL].asymmetry[b] = 0.99;
    assert_sane(&air.desc);
  }
}

/* Presets, and air in which every profile and every phase function occurs. */
static void airs_of_all_kinds_have_a_sky(void **state) {
  (void)state;
  static const char *const names[] = {"earth", "earth-hazy", "mars"};
  neph_context *context = test_context_create(1, NULL);
  for (int i = 0; i < 3; i++) {
    neph_atmosphere_desc desc;
    assert_int_equal(neph_atmosphere_get_preset(context, names[i], &desc, NULL), NEPH_OK);
    assert_sane(&desc);
  }
  neph_context_destroy(context);
  test_air air;
  describe_layered(&air);
  assert_sane(&air.desc);
}

/* ---- Layers ---- */

/* Radiance in a few directions under a sun at 60 degrees, from 100 m. */
static void look(const neph_atmosphere_desc *desc, double out[4][3]) {
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *atmosphere = test_atmosphere_create(context, desc);
  neph_sky_desc sky_desc = NEPH_SKY_DESC_DEFAULT;
  sky_desc.sun_direction[0] = sqrt(0.75);
  sky_desc.sun_direction[2] = 0.5;
  sky_desc.observer_m[2] = 100.0;
  neph_sky *sky = NULL;
  assert_int_equal(neph_sky_create(atmosphere, &sky_desc, &sky), NEPH_OK);
  const double zeniths[] = {0.0, 50.0, 85.0, 120.0};
  for (int i = 0; i < 4; i++) {
    const double angle = zeniths[i] * NP_DEGREE, direction[3] = {0.8 * sin(angle), 0.6 * sin(angle), cos(angle)};
    neph_sky_get_radiance(sky, direction, out[i]);
  }
  neph_sky_destroy(sky);
  neph_atmosphere_release(atmosphere);
  neph_context_destroy(context);
}

static void assert_same_light(double a[4][3], double b[4][3], double tolerance) {
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 3; k++) assert_near_relative(a[i][k], b[i][k], tolerance);
}

/* Half of the aerosol in a layer of its own, or the green band's in one, is the same air, gathered at more altitudes.
 */
static void layers_add_up(void **state) {
  (void)state;
  double whole[4][3], halves[4][3], bands[4][3];
  test_air air;
  test_air_start(&air);
  look(&air.desc, whole);
  test_air_scale(&air, TEST_AEROSOL, 0.5);
  air.layers[3] = air.layers[TEST_AEROSOL];
  air.desc.layer_count = 4;
  look(&air.desc, halves);
  assert_same_light(whole, halves, 1e-3);
  test_air_start(&air);
  air.layers[3] = air.layers[TEST_AEROSOL];
  air.desc.layer_count = 4;
  for (int b = 0; b < 3; b++) {
    neph_atmosphere_layer *without = &air.layers[b == 1 ? TEST_AEROSOL : 3];
    without->scattering_per_m[b] = without->absorption_per_m[b] = 0.0;
  }
  look(&air.desc, bands);
  assert_same_light(whole, bands, 1e-3);
}

/* Bands that scatter by phase functions of their own see what each would see if all did. */
static void bands_scatter_on_their_own(void **state) {
  (void)state;
  double mixed[4][3], alone[4][3];
  test_air air;
  test_air_start(&air);
  const double asymmetry[3] = {0.6, 0.7, 0.8};
  memcpy(air.layers[TEST_AEROSOL].asymmetry, asymmetry, sizeof asymmetry);
  look(&air.desc, mixed);
  for (int b = 0; b < 3; b++) {
    for (int k = 0; k < 3; k++) air.layers[TEST_AEROSOL].asymmetry[k] = asymmetry[b];
    look(&air.desc, alone);
    for (int i = 0; i < 4; i++) assert_near_relative(mixed[i][b], alone[i][b], 1e-4);
  }
}

/* An exponential in steps of a fifth of its height, linear between them, has 1.7e-3 too much of it, and points that are
 * placed otherwise; the sky moves by less than one percent. */
static void table_of_an_exponential_is_one(void **state) {
  (void)state;
  enum { ROWS = 60 };
  static double altitude[ROWS], density[ROWS];
  for (int i = 0; i < ROWS; i++) {
    altitude[i] = 240.0 * i;
    density[i] = exp(-0.2 * i);
  }
  double exponential[4][3], table[4][3];
  test_air air;
  test_air_start(&air);
  look(&air.desc, exponential);
  neph_atmosphere_layer *layer = &air.layers[TEST_AEROSOL];
  layer->profile = NEPH_LAYER_TABLE;
  layer->table_altitude_m = altitude;
  layer->table_density = density;
  layer->table_rows = ROWS;
  look(&air.desc, table);
  assert_same_light(exponential, table, 0.01);
}

/* Depths of layered air: by the table, against the quadrature that is cut at every kink. Rows are 60 m apart at the
 * edge of the fog, which costs 2 %. */
static void layered_depths_agree(void **state) {
  (void)state;
  test_air air;
  describe_layered(&air);
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *a = test_atmosphere_create(context, &air.desc);
  double error = 0.0;
  for (int h = 0; h < 12; h++)
    for (int i = 0; i <= 10; i++) {
      const double altitude = 600.0 * h, cosine = 0.1 * i;
      const np_ray ray = np_ray_make(&a->medium, altitude, cosine);
      const np_bands exact = np_ray_optical_depth(&a->medium, &ray, 0.0, ray.length_m);
      const np_depth_row row = np_depth_table_row(&a->depths, altitude);
      const np_bands table = np_depth_row_lookup(&row, (float)cosine);
      for (int b = 0; b < 3; b++)
        error = fmax(error, fabs((double)(table[b] - exact[b])) / fmax((double)exact[b], 0.02));
      np_truth_query query = test_query(altitude, 0.0, 0.0);
      query.direction = np_dvec3_make(sqrt(1.0 - cosine * cosine), 0.0, cosine);
      double truth[NP_TRUTH_BANDS];
      np_truth_transmittance(&a->medium, &query, true, truth);
      for (int b = 0; b < 3; b++) assert_near_relative(exp(-(double)exact[b]), truth[b], 1e-5);
    }
  print_message("depths of layered air by table: worst %.2g\n", error);
  assert_true(error < 0.03);
  neph_atmosphere_release(a);
  neph_context_destroy(context);
}

/* No air: black sky, clear view, and the sun as it is. */
static void no_air_is_no_sky(void **state) {
  (void)state;
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  desc.layer_count = 0;
  neph_context *context = test_context_create(1, NULL);
  neph_atmosphere *atmosphere = test_atmosphere_create(context, &desc);
  neph_sky *sky = NULL;
  assert_int_equal(neph_sky_create(atmosphere, NULL, &sky), NEPH_OK);
  for (int zenith = 0; zenith <= 180; zenith += 5) {
    const np_vec3 d = np_vec3_make((float)sin(zenith * NP_DEGREE), 0.0f, (float)cos(zenith * NP_DEGREE));
    assert_true(np_spectrum_is_zero(np_sky_radiance(sky, d)));
    const np_aerial_perspective ap = np_sky_aerial_perspective(sky, d, 1e4);
    assert_true(np_spectrum_is_zero(ap.inscatter));
    assert_near((double)ap.transmittance.band[1], 1.0, 0.0);
  }
  double sun[3], ground[3];
  neph_sky_get_irradiance(sky, sun, ground);
  assert_near_relative(sun[0], 1.474, 1e-6);
  assert_near(ground[0], 0.0, 0.0);
  neph_sky_destroy(sky);
  neph_atmosphere_release(atmosphere);
  neph_context_destroy(context);
}

/* A brighter ground lights the sky: never less with a greater albedo, and at 1 by no more than the series 1/(1 − s·a)
 * with the air's spherical albedo s < 0.3 in blue allows. */
static void bright_ground_lights_the_sky(void **state) {
  (void)state;
  double light[2];
  for (int i = 0; i < 2; i++) {
    test_air air;
    scale_air(&air, 1, 1, 1, i);
    neph_context *context = test_context_create(1, NULL);
    neph_atmosphere *atmosphere = test_atmosphere_create(context, &air.desc);
    light[i] = (double)np_atmosphere_ground_irradiance(atmosphere, 0.7f).band[2];
    neph_atmosphere_release(atmosphere);
    neph_context_destroy(context);
  }
  assert_true(light[1] > 1.2 * light[0]);
  assert_true(0.7 + light[1] < (0.7 + light[0]) / (1.0 - 0.3));
}

/* ---- Descriptions ---- */

static void assert_refused(neph_context *context, test_log *log, const neph_atmosphere_desc *desc, const char *field,
                           const char *value, const char *allowed) {
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, desc, &atmosphere), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(atmosphere);
  assert_one_error(log, field, value, allowed);
}

static void wrong_descriptions_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const neph_atmosphere_desc earth = NEPH_ATMOSPHERE_DESC_DEFAULT;
  neph_atmosphere_desc desc = earth;
  desc.planet_radius_m = 0.0;
  assert_refused(context, &log, &desc, "planet_radius_m", "is 0", "above 0");
  desc = earth;
  desc.ground_albedo[2] = 1.5;
  assert_refused(context, &log, &desc, "ground_albedo", "1.5", "at most 1");
  desc = earth;
  desc.layers = NULL;
  assert_refused(context, &log, &desc, "layers", "NULL", "3 of them");
  desc = earth;
  desc.struct_size = 3;
  neph_atmosphere *atmosphere = NULL;
  assert_int_equal(neph_atmosphere_create(context, &desc, &atmosphere), NEPH_ERROR_INVALID_ARGUMENT);
  neph_context_destroy(context);
}

/* A layer that is wrong in one thing, and what is said of it. */
typedef struct wrong_layer {
  neph_atmosphere_layer layer;
  const char *field, *value, *allowed;
} wrong_layer;

static void wrong_layers_are_refused(void **state) {
  (void)state;
  static const double falling[3] = {0.0, 2000.0, 1000.0}, rising[3] = {0.0, 1000.0, 2000.0},
                      below[3] = {1.0, -1.0, 0.0};
  const double far = (double)INFINITY, bad = (double)NAN;
  const wrong_layer wrong[] = {
      {{.profile = (neph_layer_profile)7, .top_m = far}, "layers[1].profile", "7", "neph_layer_profile"},
      {{.top_m = far, .height_m = bad}, "layers[1].height_m", "nan", "finite and above 0"},
      {{.top_m = far}, "layers[1].height_m", "is 0", "above 0"},
      {{.height_m = 1.0}, "layers[1].top_m", "is 0", "above bottom_m, 0"},
      {{.height_m = 1.0, .bottom_m = bad, .top_m = far}, "layers[1].bottom_m", "nan", "finite"},
      {{.height_m = 1.0, .bottom_m = 2e5, .top_m = far}, "top_altitude_m", "100000", "above layers[1]"},
      {{.profile = NEPH_LAYER_TENT, .top_m = far}, "layers[1].width_m", "is 0", "above 0"},
      {{.profile = NEPH_LAYER_TABLE, .top_m = far, .table_rows = 1}, "layers[1].table_rows", "is 1", "at least 2"},
      {{.profile = NEPH_LAYER_TABLE, .top_m = far, .table_rows = 3}, "layers[1].table_altitude_m", "NULL", "3 numbers"},
      {{.profile = NEPH_LAYER_TABLE,
        .top_m = far,
        .table_rows = 3,
        .table_altitude_m = falling,
        .table_density = rising},
       "layers[1].table_altitude_m[2]",
       "1000",
       "above the one before"},
      {{.profile = NEPH_LAYER_TABLE, .top_m = far, .table_rows = 3, .table_altitude_m = rising, .table_density = below},
       "layers[1].table_density[1]",
       "-1",
       "at least 0"},
      {{.height_m = 1.0, .top_m = far, .scattering_per_m = {0, -1, 0}},
       "layers[1].scattering_per_m",
       "-1",
       "at least 0"},
      {{.height_m = 1.0, .top_m = far, .absorption_per_m = {far, 0, 0}}, "layers[1].absorption_per_m", "inf", "finite"},
      {{.height_m = 1.0, .top_m = far, .phase = (neph_layer_phase)9}, "layers[1].phase", "9", "neph_layer_phase"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_LAYER_HENYEY_GREENSTEIN, .asymmetry = {0, 0, 1}},
       "layers[1].asymmetry",
       "is 1",
       "at most 0.9999"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_LAYER_TWO_LOBE, .second_asymmetry = {-1, 0, 0}},
       "layers[1].second_asymmetry",
       "-1",
       "at least -0.9999"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_LAYER_TWO_LOBE, .second_weight = {0, 1.5, 0}},
       "layers[1].second_weight",
       "1.5",
       "at most 1"},
  };
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    test_air air;
    test_air_start(&air);
    air.layers[1] = wrong[i].layer;
    assert_refused(context, &log, &air.desc, wrong[i].field, wrong[i].value, wrong[i].allowed);
  }
  test_air air;
  test_air_start(&air);
  for (int i = 1; i < 4; i++) {
    air.layers[i] = neph_earth_layers[TEST_AEROSOL];
    for (int b = 0; b < 3; b++) air.layers[i].asymmetry[b] = 0.1 * (3 * i + b - 2);
  }
  air.desc.layer_count = 4;
  assert_refused(context, &log, &air.desc, "more than 6 phase functions", "each band", "Rayleigh's");
  neph_atmosphere_desc desc;
  assert_int_equal(neph_atmosphere_get_preset(context, "venus", &desc, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "venus", "earth-hazy", "mars");
  neph_context_destroy(context);
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
      cmocka_unit_test(planets_of_all_sizes_have_a_sky),
      cmocka_unit_test(thick_and_absent_air_have_a_sky),
      cmocka_unit_test(no_air_is_no_sky),
      cmocka_unit_test(bright_ground_lights_the_sky),
      cmocka_unit_test(airs_of_all_kinds_have_a_sky),
      cmocka_unit_test(layers_add_up),
      cmocka_unit_test(bands_scatter_on_their_own),
      cmocka_unit_test(table_of_an_exponential_is_one),
      cmocka_unit_test(layered_depths_agree),
      cmocka_unit_test(wrong_descriptions_are_refused),
      cmocka_unit_test(wrong_layers_are_refused),
  };
  return cmocka_run_group_tests(tests, create_reference, release_reference);
}
