/* SPDX-License-Identifier: Apache-2.0 */
/* Airs of all kinds: layers, extremes, descriptions that are refused. */
#include "test_skies.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"

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
                                           .phase = NEPH_PHASE_HENYEY_GREENSTEIN,
                                           .asymmetry = {0.6, 0.6, 0.6}};
  air->layers[4] = (neph_atmosphere_layer){.profile = NEPH_LAYER_TENT,
                                           .top_m = (double)INFINITY,
                                           .center_m = 20000.0,
                                           .width_m = 3000.0,
                                           .scattering_per_m = {2e-6, 2e-6, 2e-6},
                                           .phase = NEPH_PHASE_TWO_LOBE,
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
    test_air_set_one_lobe(&air);
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
    neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
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

static void isotropic_air_is_henyey_greenstein_of_zero(void **state) {
  (void)state;
  double isotropic[4][3], henyey_greenstein[4][3];
  test_air air;
  test_air_start(&air);
  memset(air.layers[TEST_AEROSOL].asymmetry, 0, sizeof air.layers[TEST_AEROSOL].asymmetry);
  air.layers[TEST_AEROSOL].phase = NEPH_PHASE_HENYEY_GREENSTEIN;
  look(&air.desc, henyey_greenstein);
  air.layers[TEST_AEROSOL].phase = NEPH_PHASE_ISOTROPIC;
  look(&air.desc, isotropic);
  assert_memory_equal(isotropic, henyey_greenstein, sizeof isotropic);
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
      np_reference_query query = test_query(altitude, 0.0, 0.0);
      query.direction = np_dvec3_make(sqrt(1.0 - cosine * cosine), 0.0, cosine);
      double reference[NP_REFERENCE_BANDS];
      np_reference_transmittance(&a->medium, &query, true, reference);
      for (int b = 0; b < 3; b++) assert_near_relative(exp(-(double)exact[b]), reference[b], 1e-5);
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
    light[i] = (double)np_atmosphere_ground_irradiance(atmosphere, 0.0, 0.7f).band[2];
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
      {{.height_m = 1.0, .top_m = far, .phase = (neph_phase)9}, "layers[1].phase", "9", "neph_phase"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_PHASE_DROPLETS}, "layers[1].phase", "7", "neph_phase"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = {0, 0, 1}},
       "layers[1].asymmetry",
       "is 1",
       "at most 0.9999"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_PHASE_HAZE, .asymmetry = {0.8, 0.8, 0.4}},
       "layers[1].asymmetry",
       "is 0.4",
       "at least 0.5"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_PHASE_TWO_LOBE, .second_asymmetry = {-1, 0, 0}},
       "layers[1].second_asymmetry",
       "-1",
       "at least -0.9999"},
      {{.height_m = 1.0, .top_m = far, .phase = NEPH_PHASE_TWO_LOBE, .second_weight = {0, 1.5, 0}},
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
    air.layers[i].phase = NEPH_PHASE_CORNETTE_SHANKS;
    for (int b = 0; b < 3; b++) air.layers[i].asymmetry[b] = 0.1 * (3 * i + b - 2);
  }
  air.desc.layer_count = 4;
  assert_refused(context, &log, &air.desc, "more than 6 phase functions", "each band", "Rayleigh's");
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  assert_int_equal(neph_atmosphere_get_preset(context, "venus", &desc, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "venus", "earth-hazy", "mars");
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(planets_of_all_sizes_have_a_sky),
      cmocka_unit_test(thick_and_absent_air_have_a_sky),
      cmocka_unit_test(no_air_is_no_sky),
      cmocka_unit_test(bright_ground_lights_the_sky),
      cmocka_unit_test(airs_of_all_kinds_have_a_sky),
      cmocka_unit_test(layers_add_up),
      cmocka_unit_test(bands_scatter_on_their_own),
      cmocka_unit_test(isotropic_air_is_henyey_greenstein_of_zero),
      cmocka_unit_test(table_of_an_exponential_is_one),
      cmocka_unit_test(layered_depths_agree),
      cmocka_unit_test(wrong_descriptions_are_refused),
      cmocka_unit_test(wrong_layers_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
