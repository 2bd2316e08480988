/* SPDX-License-Identifier: Apache-2.0 */
/* Atmospheres of other planets: tables against the tracer, row by row of tests/data/airs/traced.csv, whose header has
 * its command. */
#include <string.h>

#include "core/units.h"
#include "test_reference_rows.h"

#define AIRS NEPHOS_TEST_SOURCE_DIR "/data/airs/"

enum { EARTH = 1, SUN = 5 }; /* columns */

typedef struct bound {
  const char *earth;
  double sun_min, sun_max; /* zenith angles, deg */
  double rms_max;
} bound;

/* Mean square of the relative error in one band, the reference's own noise taken off, and what that leaves in doubt:
 * sqrt(2/n) of the noise's mean square. */
static double measure(const np_csv *csv, const bound *g, int band, double *out_doubt) {
  double square = 0.0, noise = 0.0, count = 0.0;
  for (size_t i = 0; i < csv->row_count; i++) {
    const double sun = test_row_get(csv, i, SUN);
    if (strcmp(np_csv_get_field(csv, i, EARTH), g->earth) != 0 || sun < g->sun_min || sun > g->sun_max) continue;
    const double reference = test_row_get(csv, i, TEST_REFERENCE + band),
                 error = test_row_get(csv, i, TEST_REFERENCE + 3 + band) / reference;
    const double off = test_row_get(csv, i, TEST_ANSWER + band) / reference - 1.0;
    square += off * off;
    noise += error * error;
    count += 1.0;
  }
  assert_true(count > 0.0);
  *out_doubt = sqrt(2.0 / count) * noise / count;
  return square / count - noise / count;
}

/* Limits, in round figures above the measured errors (docs/results/sky.md). Twice the doubt that the reference's
 * noise leaves comes on top. */
static void tables_agree_with_the_tracer(void **state) {
  (void)state;
  static const bound bounds[] = {
      {"earth-hazy", 0, 70, 0.007},
      {"earth-hazy", 85, 85, 0.015},
      {"earth-hazy", 93, 93, 0.06},
      {"mars", 0, 70, 0.045},
      {"mars", 85, 85, 0.1},
      {"mars", 93, 93, 0.3},
      {"haze20.yaml", 0, 70, 0.007},
      {"haze20.yaml", 85, 85, 0.035},
      {"haze20.yaml", 93, 93, 0.08},
      {"layered.yaml", 0, 70, 0.015},
      {"layered.yaml", 85, 85, 0.015},
      {"layered.yaml", 93, 93, 0.07},
      {"coloured.yaml", 0, 70, 0.007},
      {"coloured.yaml", 85, 85, 0.02},
      {"coloured.yaml", 93, 93, 0.06},
      {"two_lobe.yaml", 0, 70, 0.007},
      {"two_lobe.yaml", 85, 85, 0.02},
      {"two_lobe.yaml", 93, 93, 0.025},
      {"planet_small.yaml", 0, 90, 0.007},
      {"planet_large.yaml", 0, 90, 0.007},
      {"thin100.yaml", 0, 90, 0.007},
      {"white.yaml", 0, 90, 0.01},
      {"black.yaml", 0, 90, 0.007},
      {"no_molecules.yaml", 0, 90, 0.007},
      {"no_aerosol.yaml", 0, 90, 0.007},
      {"no_ozone.yaml", 0, 90, 0.007},
      {"earth", 0, 85, 0.007},
      {"earth", 93, 93, 0.02},
      {"clear.yaml", 0, 70, 0.007},
      {"clear.yaml", 85, 85, 0.015},
      {"clear.yaml", 93, 93, 0.06},
      {"hazy.yaml", 0, 70, 0.015},
      {"hazy.yaml", 85, 85, 0.045},
      {"hazy.yaml", 93, 93, 0.07},
      {"maritime.yaml", 0, 70, 0.015},
      {"maritime.yaml", 85, 85, 0.025},
      {"maritime.yaml", 93, 93, 0.05},
      {"dusty.yaml", 0, 70, 0.02},
      {"dusty.yaml", 85, 85, 0.035},
      {"dusty.yaml", 93, 93, 0.07},
  };
  neph_context *context = test_context_create(2, NULL);
  np_csv csv;
  test_rows_ask(context, AIRS "traced.csv", NULL, &csv);
  bool is_good = true;
  for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) {
    const bound *g = &bounds[i];
    double rms[3], known[3];
    bool passes = true;
    for (int b = 0; b < 3; b++) {
      double doubt;
      const double square = measure(&csv, g, b, &doubt);
      passes = passes && square <= g->rms_max * g->rms_max + 2.0 * doubt;
      rms[b] = 100.0 * sqrt(fmax(square, 0.0));
      known[b] = 100.0 * sqrt(2.0 * doubt);
    }
    print_message("%s, sun %g to %g deg: %.2f / %.2f / %.2f %% (known to %.2f / %.2f / %.2f, bound %.1f %%)%s\n",
                  g->earth, g->sun_min, g->sun_max, rms[0], rms[1], rms[2], known[0], known[1], known[2],
                  100.0 * g->rms_max, passes ? "" : " FAILS");
    is_good = is_good && passes;
  }
  np_csv_clear(&csv);
  neph_context_destroy(context);
  assert_true(is_good);
}

/* Each air once. */
static void some_rows_trace_as_stored(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  char *folder = test_folder_create(), *cases = test_path(folder, "cases.csv");
  np_csv reference;
  assert_int_equal(np_csv_load(context, AIRS "traced.csv", &reference), NEPH_OK);
  FILE *file = fopen(cases, "w");
  fprintf(file, "%s\n", reference.header.text);
  for (size_t i = 0; i < reference.row_count; i++)
    if (!i || strcmp(np_csv_get_field(&reference, i, EARTH), np_csv_get_field(&reference, i - 1, EARTH)) != 0)
      test_rows_write_case(file, &reference, i, AIRS);
  fclose(file);
  test_rows_trace_anew(context, cases, 1024);
  np_csv_clear(&reference);
  free(cases);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

/* In-scatter of Mars' sky per unit of the sun's, red and blue, `angle_deg` beside a sun at `sun_deg` above the horizon.
 */
static void look_at_mars(neph_atmosphere *mars, double sun_deg, double angle_deg, double out[3]) {
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  const double sun = sun_deg * NP_DEGREE, angle = angle_deg * NP_DEGREE;
  const double to_sun[3] = {cos(sun), 0.0, sin(sun)};
  const double view[3] = {cos(sun) * cos(angle), cos(sun) * sin(angle), sin(sun)};
  memcpy(desc.sun_direction, to_sun, sizeof to_sun);
  for (int b = 0; b < 3; b++) desc.sun_irradiance_w_m2_nm[b] = 1.0;
  desc.observer_m[2] = 2.0;
  neph_sky *sky = NULL;
  assert_int_equal(neph_sky_create(mars, &desc, &sky), NEPH_OK);
  neph_sky_get_radiance(sky, view, out);
  neph_sky_destroy(sky);
}

/* The day sky is butterscotch, twice as red as blue; around a low sun it is blue, and red again 40 degrees away. */
static void mars_has_a_blue_sunset(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  double distance_au, noon[3], near[3], far[3];
  assert_int_equal(neph_atmosphere_get_preset(context, "mars", &desc, &distance_au), NEPH_OK);
  assert_near(distance_au, 1.524, 0.0);
  neph_atmosphere *mars = NULL;
  assert_int_equal(neph_atmosphere_create(context, &desc, &mars), NEPH_OK);
  look_at_mars(mars, 50.0, 90.0, noon);
  look_at_mars(mars, 3.0, 2.0, near);
  look_at_mars(mars, 3.0, 40.0, far);
  print_message("Mars, blue over red: by day %.2f; about a low sun %.2f, 40 degrees beside it %.2f\n",
                noon[2] / noon[0], near[2] / near[0], far[2] / far[0]);
  assert_true(noon[2] < 0.7 * noon[0]);
  assert_true(near[2] > 1.2 * near[0]);
  assert_true(far[2] < far[0]);
  neph_atmosphere_release(mars);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tables_agree_with_the_tracer),
      cmocka_unit_test(some_rows_trace_as_stored),
      cmocka_unit_test(mars_has_a_blue_sunset),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
