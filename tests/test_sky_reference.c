/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"
#include "test_skies.h"

#include <stdlib.h>

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/sky_reference.h"
#include "core/random.h"

static int create_context(void **state) {
  *state = test_context_create(1, NULL);
  return 0;
}

static int destroy_context(void **state) {
  neph_context_destroy(*state);
  return 0;
}

/* Four standard errors of 64 batches: one value in 6000 lies beyond by chance; the seeds are fixed, so none does. */
static const double sigmas = 4.0;

static void assert_within_errors(const np_reference_value *value, const double expected[3]) {
  for (int b = 0; b < 3; b++) {
    assert_true(value->error[b] > 0.0);
    assert_near(value->mean[b], expected[b], sigmas * value->error[b]);
  }
}

/* Air that absorbs nothing over a ground that absorbs nothing. */
static neph_atmosphere *create_white(neph_context *context) {
  test_air air;
  test_air_start(&air);
  test_air_scale(&air, TEST_OZONE, 0.0);
  test_air_set_albedo(&air, 1.0);
  for (int b = 0; b < 3; b++) {
    air.layers[TEST_AEROSOL].scattering_per_m[b] = 20e-6 * (b + 1);
    air.layers[TEST_AEROSOL].absorption_per_m[b] = 0.0;
  }
  return test_atmosphere_create(context, &air.desc);
}

/* Under a white sky of radiance 1 everything looks 1: what air scatters in is what it takes out. */
static void furnace_is_white(void **state) {
  neph_context *context = *state;
  neph_atmosphere *white = create_white(context);
  const np_reference_scene scene = {
      .medium = &white->medium, .light = NP_REFERENCE_FURNACE, .order_min = 1, .order_max = NP_REFERENCE_ORDERS_ALL};
  const double zeniths[] = {20.0, 88.0, 91.0, 150.0}, heights[] = {0.0, 3e3, 40e3, 1e3};
  for (int i = 0; i < 4; i++) {
    const np_reference_query query = test_query(heights[i], zeniths[i], 30.0);
    const np_ray ray = np_ray_make(&white->medium, heights[i], cos(zeniths[i] * NP_DEGREE));
    np_reference_path path;
    np_reference_path_build(&white->medium, &ray, 20, &path);
    double expected[3];
    np_reference_path_transmit(&path, expected);
    for (int b = 0; b < 3; b++) expected[b] = 1.0 - expected[b];
    np_reference_value value;
    assert_int_equal(np_reference_radiance(context, NULL, &scene, &query, 6000, 1, &value), NEPH_OK);
    for (int b = 0; b < 3; b++)
      print_message("furnace, zenith %g deg, band %d: %.5f +- %.5f, expected %.5f\n", zeniths[i], b, value.mean[b],
                    value.error[b], expected[b]);
    assert_within_errors(&value, expected);
  }
  neph_atmosphere_release(white);
}

/* Radiances of points on the top and of directions into it, drawn evenly: by a Kronecker sequence (Roberts 2018, "The
 * Unreasonable Effectiveness of Quasirandom Sequences", in three dimensions), shifted at random. Replicates are
 * independent, and give the error of their mean. */
enum { REPLICATES = 24, RAYS = 96 };

static void average_top(neph_context *context, np_reference_scene *scene, int replicate, double out[3]) {
  static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  np_random random = np_random_start(3, 0, 0, (uint32_t)replicate, 0);
  double shift[3];
  for (int k = 0; k < 3; k++) shift[k] = np_random_double(&random);
  memset(out, 0, 3 * sizeof *out);
  for (int i = 0; i < RAYS; i++) {
    double u[3];
    for (int k = 0; k < 3; k++) u[k] = fmod(shift[k] + (i + 1) * step[k], 1.0);
    /* The observer stands still, the sun turns: the same by symmetry. */
    scene->to_sun = test_direction(acos(2.0 * u[0] - 1.0) / NP_DEGREE, 0.0);
    const np_reference_query query =
        test_query(scene->medium->top_m, 180.0 - acos(sqrt(u[1])) / NP_DEGREE, 360.0 * u[2]);
    np_reference_value value;
    const uint64_t seed = (uint64_t)(replicate * RAYS + i);
    assert_int_equal(np_reference_trace(context, NULL, scene, &query, 1, seed, &value), NEPH_OK);
    for (int b = 0; b < 3; b++) out[b] += value.mean[b] / RAYS;
  }
}

/* All light that enters leaves: of the sun's flux through the planet's disk, π·R_top², what does not go through the
 * limb unscattered comes out scattered. Points on the top and directions into it are drawn evenly: the mean of
 * 4π·R_top²·π·L over them is the flux out. */
static void energy_is_kept(void **state) {
  neph_context *context = *state;
  neph_atmosphere *white = create_white(context);
  const np_medium *medium = &white->medium;
  const double radius = medium->planet_radius_m, top = radius + medium->top_m;
  np_reference_scene scene = {.medium = medium,
                              .light = NP_REFERENCE_DISK,
                              .sun_angular_radius_rad = 0.00467396,
                              .order_min = 1,
                              .order_max = NP_REFERENCE_ORDERS_ALL,
                              .has_ground = true};
  double sum[3] = {0}, square[3] = {0};
  for (int i = 0; i < REPLICATES; i++) {
    double mean[3];
    average_top(context, &scene, i, mean);
    for (int b = 0; b < 3; b++) {
      sum[b] += mean[b] / REPLICATES;
      square[b] += mean[b] * mean[b] / REPLICATES;
    }
  }
  enum { LIMB = 400 };
  for (int b = 0; b < 3; b++) {
    double through = 0.0;
    for (int i = 0; i < LIMB; i++) {
      const double height = medium->top_m * (i + 0.5) / LIMB, r = radius + height;
      double t[3];
      np_reference_transmit_to_space(medium, height, 0.0, t);
      through += 2.0 * r * medium->top_m / LIMB / (top * top) * t[b] * t[b];
    }
    const double out = 4.0 * NP_PI * sum[b];
    const double error = 4.0 * NP_PI * sqrt((square[b] - sum[b] * sum[b]) / (REPLICATES - 1.0));
    print_message("energy, band %d: %.5f +- %.5f out, %.5f through the limb\n", b, out, error, through);
    assert_near(out + through, 1.0, sigmas * error);
  }
  neph_atmosphere_release(white);
}

/* ---- Against another tracer ---- */

typedef struct reference_row {
  double altitude_km, sun_deg, zenith_deg, azimuth_deg;
  int band;
  double first, second, all, error;
} reference_row;

static bool read_row(FILE *file, reference_row *row) {
  char line[256];
  while (fgets(line, sizeof line, file))
    if (sscanf(line, "%lf,%lf,%lf,%lf,%d,%lf,%lf,%lf,%lf", &row->altitude_km, &row->sun_deg, &row->zenith_deg,
               &row->azimuth_deg, &row->band, &row->first, &row->second, &row->all, &row->error) == 9)
      return true;
  return false;
}

/* The tracer's radiance of a row's ray. */
typedef struct traced {
  double first[3];
  np_reference_value all;
} traced;

static traced trace_row(neph_context *context, const neph_atmosphere *earth, const reference_row *row, uint64_t seed) {
  const np_reference_scene scene = {.medium = &earth->medium,
                                    .light = NP_REFERENCE_POINT,
                                    .to_sun = test_direction(row->sun_deg, 0.0),
                                    .sun_angular_radius_rad = 0.004675,
                                    .order_min = 1,
                                    .order_max = 64,
                                    .guide = &earth->depths};
  const np_reference_query query = test_query(row->altitude_km * NP_KILOMETRE, row->zenith_deg, row->azimuth_deg);
  traced t;
  np_reference_first_order(&scene, &query, 1e-5, t.first);
  assert_int_equal(np_reference_radiance(context, NULL, &scene, &query, 2000, seed, &t.all), NEPH_OK);
  return t;
}

/* Every ninth direction of tests/data/sky_reference.csv, whose bands follow each other: order 1 to 1e-4, the accuracy
 * of its own quadrature, all orders within four standard errors of both. */
static void independent_tracer_agrees(void **state) {
  test_air air;
  test_air_start(&air);
  test_air_set_one_lobe(&air);
  neph_atmosphere *earth = test_atmosphere_create(*state, &air.desc);
  FILE *file = fopen(NEPHOS_TEST_SOURCE_DIR "/data/sky_reference.csv", "r");
  assert_non_null(file);
  reference_row row;
  traced ours;
  double worst_first = 0.0, square = 0.0;
  unsigned count = 0;
  for (unsigned i = 0; read_row(file, &row); i++) {
    if (i % 27 >= 3) continue;
    if (row.band == 0) ours = trace_row(*state, earth, &row, i);
    const double error = hypot(ours.all.error[row.band], row.error), off = ours.all.mean[row.band] - row.all;
    worst_first = fmax(worst_first, fabs(ours.first[row.band] / row.first - 1.0));
    square += off * off / (error * error);
    count++;
    assert_near_relative(ours.first[row.band], row.first, 1e-4);
    assert_near(ours.all.mean[row.band], row.all, sigmas * error);
  }
  print_message("another tracer, %u rows: order 1 to %.1e, all orders %.2f standard errors rms\n", count, worst_first,
                sqrt(square / count));
  fclose(file);
  neph_atmosphere_release(earth);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(furnace_is_white),
      cmocka_unit_test(energy_is_kept),
      cmocka_unit_test(independent_tracer_agrees),
  };
  return cmocka_run_group_tests(tests, create_context, destroy_context);
}
