/* SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "core/random.h"
#include "core/stable.h"
#include "optics/phase.h"
#include "test_support.h"

static double eval(const np_phase *phase, double versine) { return (double)np_phase_eval(phase, (float)versine); }

/* Cases of each kind, narrow and wide, forward and backward. Tables have tests of their own (test_phase_bands.c). */
static const np_phase_source examples[] = {
    {.kind = NEPH_PHASE_ISOTROPIC},
    {.kind = NEPH_PHASE_RAYLEIGH},
    {.kind = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = 1e-6},
    {.kind = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = 0.5},
    {.kind = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = 0.99},
    {.kind = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = 0.9999},
    {.kind = NEPH_PHASE_HENYEY_GREENSTEIN, .asymmetry = -0.85},
    {.kind = NEPH_PHASE_TWO_LOBE, .forward = 0.9, .backward = -0.4, .backward_weight = 0.2},
    {.kind = NEPH_PHASE_CORNETTE_SHANKS, .asymmetry = 0.8},
    {.kind = NEPH_PHASE_CORNETTE_SHANKS, .asymmetry = -0.6},
    {.kind = NEPH_PHASE_HAZE, .asymmetry = NP_PHASE_HAZE_MIN},
    {.kind = NEPH_PHASE_HAZE, .asymmetry = 0.8},
    {.kind = NEPH_PHASE_HAZE, .asymmetry = NP_PHASE_HAZE_MAX},
    {.kind = NEPH_PHASE_DRAINE, .draine_asymmetry = 1e-4, .alpha = 40.0},
    {.kind = NEPH_PHASE_DRAINE, .draine_asymmetry = 0.9999, .alpha = 300.0},
    {.kind = NEPH_PHASE_DROPLETS, .diameter_m = 5e-6},
    {.kind = NEPH_PHASE_DROPLETS, .diameter_m = 10e-6},
    {.kind = NEPH_PHASE_DROPLETS, .diameter_m = 20e-6},
    {.kind = NEPH_PHASE_DROPLETS, .diameter_m = 35e-6},
    {.kind = NEPH_PHASE_DROPLETS, .diameter_m = 50e-6},
    {.kind = NEPH_PHASE_TABLE},
    {.kind = NEPH_PHASE_MIE},
    {.kind = NEPH_PHASE_RAIN},
    {.kind = NEPH_PHASE_ICE},
};
enum { KIND_COUNT = sizeof examples / sizeof *examples };

static np_phase make_kind(int i) { return np_phase_make(&examples[i]); }

static void every_kind_has_an_example(void **state) {
  (void)state;
  unsigned seen = 0;
  for (int i = 0; i < KIND_COUNT; i++) seen |= 1u << examples[i].kind;
  assert_int_equal(seen, (1u << NP_PHASE_COUNT) - 1u);
}

/* Half the sphere, in x = log(1 + s/s0) of the versine s from one pole: the peak of g = 0.9999 (s0 = 1e-8) and the tail
 * get equally many nodes. */
enum { NODES = 8192 };
static const double peak_versine = 1e-8;

static double get_node_versine(int node) { return peak_versine * expm1(node * log1p(1.0 / peak_versine) / NODES); }

/* 2π·∫ p·f dv by Simpson's rule over both halves; f is P_l(μ). Its own error is below 1e-9; that of the float values,
 * a few 1e-7, is what tolerances allow for. */
static double legendre(int l, double mu) {
  double previous = 1.0, current = mu;
  if (l == 0) return 1.0;
  for (int k = 1; k < l; k++) {
    double next = ((2 * k + 1) * mu * current - k * previous) / (k + 1);
    previous = current;
    current = next;
  }
  return current;
}

static double integrate(const np_phase *phase, int l) {
  double step = log1p(1.0 / peak_versine) / NODES, sum = 0;
  for (int node = 0; node <= NODES; node++) {
    double s = get_node_versine(node), weight = (node == 0 || node == NODES) ? 1.0 : (node % 2) ? 4.0 : 2.0;
    double front = eval(phase, s) * legendre(l, 1.0 - s);
    double back = eval(phase, 2.0 - s) * legendre(l, s - 1.0);
    sum += weight * (front + back) * (s + peak_versine);
  }
  return 2.0 * NP_PI * sum * step / 3.0;
}

/* 2e-6: each value carries about ten float roundings of 6e-8. */
static void every_kind_integrates_to_one(void **state) {
  (void)state;
  for (int i = 0; i < KIND_COUNT; i++) {
    np_phase phase = make_kind(i);
    assert_near(integrate(&phase, 0), 1.0, 2e-6);
  }
}

static void mean_cosine_and_moments_agree_with_quadrature(void **state) {
  (void)state;
  for (int i = 0; i < KIND_COUNT; i++) {
    np_phase phase = make_kind(i);
    double moments[24];
    np_phase_get_moments(&phase, 24, moments);
    assert_near(moments[0], 1.0, 1e-15);
    assert_near(moments[1], np_phase_mean_cosine(&phase), 1e-14);
    for (int l = 1; l < 24; l++) assert_near(moments[l], integrate(&phase, l), 2e-6);
  }
}

/* Tolerance: the four digits printed for the fit. */
static void droplets_have_the_published_mean_cosine(void **state) {
  (void)state;
  const double diameter_um[] = {5, 10, 20, 50}, published[] = {0.8434, 0.8642, 0.8793, 0.8912};
  for (int i = 0; i < 4; i++) {
    np_phase phase = np_phase_droplets(diameter_um[i] * 1e-6);
    assert_near(np_phase_mean_cosine(&phase), published[i], 0.5e-4);
  }
}

/* Tolerance: the two digits known. */
static void droplets_have_the_known_peak(void **state) {
  (void)state;
  np_phase phase = np_phase_droplets(50e-6);
  assert_near(eval(&phase, 0), 1.9e4, 0.05e4);
}

/* The mean cosine is the parameter, and shares of the lobes are those of the fit: the aureole of haze is ten times as
 * bright 0.7° from the sun as 6.7° from it, where one lobe has 1.1. */
static void haze_has_its_mean_and_an_aureole(void **state) {
  (void)state;
  for (double g = NP_PHASE_HAZE_MIN; g < NP_PHASE_HAZE_MAX; g += 0.05) {
    const np_phase phase = np_phase_haze(g);
    assert_near(np_phase_mean_cosine(&phase), g, 1e-7);
    assert_near((double)np_phase_get_share(&phase, 0), 0.47, 1e-7);
    assert_near((double)np_phase_get_share(&phase, 1), 0.48, 1e-7);
    assert_near((double)np_phase_get_share(&phase, 2), 0.05, 1e-7);
    const double near = 1.0 - cos(0.7 * NP_DEGREE), far = 1.0 - cos(6.7 * NP_DEGREE);
    print_message("g %.2f: %.2f\n", g, eval(&phase, near) / eval(&phase, far));
    assert_true(eval(&phase, near) > 7.0 * eval(&phase, far));
  }
}

/* Mirroring g mirrors the function: the same float operations, so the same bits where 2 − v is exact. */
static void negative_g_is_the_mirror_image(void **state) {
  (void)state;
  for (float g = 0.0625f; g < 1.0f; g += 0.0625f)
    for (float v = 0; v <= 2.0f; v += 0.015625f) {
      np_phase ahead = np_phase_cornette_shanks(g), behind = np_phase_cornette_shanks(-g);
      assert_true(np_phase_eval(&ahead, v) == np_phase_eval(&behind, 2.0f - v));
    }
}

/* g = 0.999999 in float against the textbook formula in double: 1 − g and the versine are exact, so only roundings. */
static void narrow_peaks_keep_their_digits(void **state) {
  (void)state;
  np_phase phase = np_phase_henyey_greenstein(0.999999f);
  const double g = (double)0.999999f;
  for (double v = 0x1p-46; v < 2.0; v *= 2.0) {
    double distance2 = (1.0 - g) * (1.0 - g) + 2.0 * g * v;
    double exact = (1.0 - g * g) / (4.0 * NP_PI * pow(distance2, 1.5));
    assert_near(eval(&phase, v) / exact, 1.0, 1e-6);
  }
}

/* Cumulative distribution in the versine, by the trapezium rule on the nodes of both halves. */
typedef struct cdf_table {
  double versine[2 * NODES + 2], cdf[2 * NODES + 2];
} cdf_table;

static void build_cdf(const np_phase *phase, cdf_table *table) {
  for (int node = 0; node <= NODES; node++) {
    table->versine[node] = get_node_versine(node);
    table->versine[2 * NODES + 1 - node] = 2.0 - get_node_versine(node);
  }
  table->cdf[0] = 0;
  for (int i = 1; i < 2 * NODES + 2; i++) {
    double a = table->versine[i - 1], b = table->versine[i];
    double mean = (eval(phase, a) + 4.0 * eval(phase, 0.5 * (a + b)) + eval(phase, b)) / 6.0;
    table->cdf[i] = table->cdf[i - 1] + 2.0 * NP_PI * mean * (b - a);
  }
}

static double look_up_cdf(const cdf_table *table, double versine) {
  int low = 0, high = 2 * NODES + 1;
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (table->versine[middle] <= versine)
      low = middle;
    else
      high = middle;
  }
  double span = table->versine[high] - table->versine[low];
  double t = span > 0 ? (versine - table->versine[low]) / span : 0;
  return table->cdf[low] + t * (table->cdf[high] - table->cdf[low]);
}

/* Samples, put through the quadrature's cumulative distribution, must be uniform, and so must their azimuths. 64 bins
 * of each, 63 degrees of freedom: mean 63, σ 11.2; 130 is 6 σ. The seed is fixed. */
static void assert_samples_follow(const np_phase *phase, uint64_t seed) {
  enum { BINS = 64, SAMPLES = 1 << 17 };
  static cdf_table table;
  unsigned count[BINS] = {0}, azimuth_count[BINS] = {0};
  build_cdf(phase, &table);
  np_vec3 forward = np_vec3_normalize(np_vec3_make(0.3f, -0.5f, -0.8f)), tangent, bitangent;
  np_frame_around(forward, &tangent, &bitangent);
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  for (int i = 0; i < SAMPLES; i++) {
    float u[3] = {np_random_float(&random), np_random_float(&random), np_random_float(&random)}, value;
    np_vec3 d = np_phase_sample(phase, forward, u, &value);
    double versine = (double)np_vec3_versine(d, forward);
    double azimuth = 0.5 + (double)(atan2f(np_vec3_dot(d, bitangent), np_vec3_dot(d, tangent)) / (2.0f * NP_PI_F));
    count[(int)np_clamp(look_up_cdf(&table, versine) * BINS, 0, BINS - 1)]++;
    azimuth_count[(int)np_clamp(azimuth * BINS, 0, BINS - 1)]++;
  }
  double chi2 = 0, azimuth_chi2 = 0, expected = (double)SAMPLES / BINS;
  for (int b = 0; b < BINS; b++) {
    chi2 += (count[b] - expected) * (count[b] - expected) / expected;
    azimuth_chi2 += (azimuth_count[b] - expected) * (azimuth_count[b] - expected) / expected;
  }
  if (chi2 >= 130.0 || azimuth_chi2 >= 130.0) fail_msg("chi-square %g, azimuth %g", chi2, azimuth_chi2);
}

static void samples_follow_the_function(void **state) {
  (void)state;
  for (int i = 0; i < KIND_COUNT; i++) {
    np_phase phase = make_kind(i);
    assert_samples_follow(&phase, (uint64_t)i + 1);
  }
}

/* The value handed out with a sample is the function there. Away from the peak a float direction gives its versine back
 * to 1e-6 or so; 1e-4 leaves room for the slope of the function. */
static void sample_value_is_eval(void **state) {
  (void)state;
  np_phase phase = np_phase_droplets(20e-6);
  np_random random = np_random_start(5, 0, 0, 0, 0);
  np_vec3 forward = {0, 0, -1};
  for (int i = 0; i < 10000; i++) {
    float u[3] = {np_random_float(&random), np_random_float(&random), np_random_float(&random)}, value;
    np_vec3 d = np_phase_sample(&phase, forward, u, &value);
    float versine = np_vec3_versine(d, forward);
    if (versine > 0.01f) assert_true(fabsf(value / np_phase_eval(&phase, versine) - 1.0f) < 1e-4f);
  }
}

/* Ends of the unit interval, poles of the frame, the narrowest lobes allowed. A normalised float vector's length is one
 * to 2e-7. */
static void extremes_give_finite_unit_directions(void **state) {
  (void)state;
  const float ends[] = {0.0f, FLT_MIN, 0.5f, 1.0f - 0x1p-24f}, gs[] = {-0.999999f, -1e-30f, 0.0f, 1e-30f, 0.999999f};
  const np_vec3 axes[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
  for (int i = 0; i < 4 * 4 * 4 * 4 * 5 * 3; i++) {
    np_phase phase = {.lobe = {{gs[i / 256 % 5], (float[]){0, 1, 1000}[i / 1280]}}};
    float u[3] = {ends[i % 4], ends[i / 4 % 4], ends[i / 16 % 4]}, value;
    np_vec3 d = np_phase_sample(&phase, axes[i / 64 % 4], u, &value);
    assert_true(isfinite(value) && value >= 0);
    assert_true(fabsf(np_vec3_length(d) - 1.0f) < 4e-7f);
  }
}

/* Broadening scales each lobe's g, and ends in isotropy. */
/* A versine rounded above 2, as directions in float give it, is 2: no peak backwards is the root of less than nothing.
 */
static void a_backward_peak_is_finite_past_its_end(void **state) {
  (void)state;
  const np_phase phase = np_phase_henyey_greenstein(-0.999999f);
  for (float versine = 2.0f; versine < 2.000001f; versine = nextafterf(versine, 3.0f)) {
    const float value = np_phase_eval(&phase, versine);
    assert_true(isfinite(value) && value > 0.0f);
  }
}

static void broadening_ends_isotropic(void **state) {
  (void)state;
  np_phase droplets = np_phase_droplets(20e-6), none = np_phase_broaden(&droplets, 0);
  np_phase hg = np_phase_henyey_greenstein(0.8f), half = np_phase_broaden(&hg, 0.5f);
  assert_true(np_phase_mean_cosine(&none) == 0);
  for (double v = 0; v <= 2.0; v += 0.25) assert_near(eval(&none, v), 1.0 / (4.0 * NP_PI), 1e-8);
  assert_near(np_phase_mean_cosine(&half), 0.4, 1e-7);
}

/* ---- Tables ---- */

static int set_up(void **state) { return test_set_up(state, 1, "phase.csv"); }

/* Values of a phase function times a factor, at angles that crowd towards 0 as its peak does. */
static void write_table(const test_fixture *f, const np_phase *phase, int count, double factor, bool is_reversed) {
  FILE *file = fopen(f->path, "w");
  assert_non_null(file);
  fprintf(file, "# made up\nvalue,angle_deg\n");
  for (int row = 0; row < count; row++) {
    const double t = (is_reversed ? count - 1 - row : row) / (count - 1.0), angle_deg = 180.0 * t * t * t;
    const double sine = sin(angle_deg * NP_PI / 360.0);
    fprintf(file, "%.12g,%.12g\n", factor * eval(phase, 2.0 * sine * sine), angle_deg);
  }
  fclose(file);
}

/* A fine table of the droplets' function is that function: 1000 rows leave 2e-4 of its value between them. */
static void a_fine_table_is_its_function(void **state) {
  test_fixture *f = *state;
  np_phase_table table;
  const np_phase droplets = np_phase_droplets(20e-6);
  for (int is_reversed = 0; is_reversed < 2; is_reversed++) {
    write_table(f, &droplets, 1000, 1.005, is_reversed);
    assert_int_equal(np_phase_table_load(f->context, f->path, &table), NEPH_OK);
    const np_phase phase = np_phase_tabulated(&table);
    double moments[24], expected[24];
    np_phase_get_moments(&phase, 24, moments);
    np_phase_get_moments(&droplets, 24, expected);
    assert_near(moments[0], 1.0, 1e-6); /* float values */
    for (int l = 1; l < 24; l++) assert_near(moments[l], expected[l], 5e-4);
    for (double v = 1e-6; v < 2.0; v *= 1.7) assert_near_relative(eval(&phase, v), eval(&droplets, v), 2e-3);
    assert_samples_follow(&phase, 77 + (uint64_t)is_reversed);
    np_phase_table_clear(&table);
  }
}

/* Linear from (1 − ½)/4π behind to (1 + ½)/4π ahead: mean cosine ½/3, all higher moments 0, a half of it its mixture
 * with isotropy. By cosines, whose order is that of the file. */
static void a_coarse_table_is_linear_in_the_cosine(void **state) {
  test_fixture *f = *state;
  np_phase_table table;
  test_file_write_text(f->path, "cosine,value\n-1,0.0397887\n0.5,0.0994718\n1,0.1193662\n");
  assert_int_equal(np_phase_table_load(f->context, f->path, &table), NEPH_OK);
  const np_phase phase = np_phase_tabulated(&table), half = np_phase_broaden(&phase, 0.5f);
  double moments[4];
  np_phase_get_moments(&phase, 4, moments);
  assert_near(moments[1], 0.5 / 3.0, 1e-6); /* seven digits are written */
  assert_near(moments[2], 0.0, 1e-6);
  assert_near(moments[3], 0.0, 1e-6);
  assert_near(np_phase_mean_cosine(&half), 0.25 / 3.0, 1e-6);
  for (double v = 0; v <= 2.0; v += 0.125)
    assert_near_relative(eval(&phase, v), (1.0 + 0.5 * (1.0 - v)) / (4.0 * NP_PI), 1e-6);
  assert_samples_follow(&phase, 80);
  assert_samples_follow(&half, 81);
  np_phase_table_clear(&table);
}

static void wrong_tables_are_refused(void **state) {
  test_fixture *f = *state;
  np_phase_table table;
  static const struct {
    const char *text, *message;
  } cases[] = {
      {"angle_deg,value\n0,0.1\n180,0.1\n", "integrates to 1.25664 over the sphere, must be 1 within 1 %"},
      {"angle_deg,value\n0,0\n180,0\n", "integrates to 0 over"},
      {"angle_deg,value\n0,1\n180,-1\n", "phase.csv:3: value is '-1'"},
      {"angle_deg,value\n0,nan\n180,1\n", "phase.csv:2: value is 'nan'"},
      {"angle_deg,value\n0,1\n170,1\n", "phase.csv:3: angle_deg must run from 0 to 180"},
      {"cosine,value\n0.9,1\n-1,1\n", "phase.csv:2: cosine must run from 1 to -1"},
      {"angle_deg,value\n0,1\n90,1\n80,1\n180,1\n", "phase.csv:4: angle_deg must run"},
      {"angle_deg,value\n0,1\n0,1\n180,1\n", "phase.csv:3: angle_deg must run"},
      {"angle,value\n0,1\n180,1\n", "phase.csv:1: a phase function needs the columns value and"},
      {"angle_deg,value\n0,1\n", "has 1 rows"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    test_file_write_text(f->path, cases[i].text);
    assert_int_equal(np_phase_table_load(f->context, f->path, &table), NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, cases[i].message);
  }
}

static neph_result load_table(neph_context *context, void *path) {
  np_phase_table table;
  neph_result result = np_phase_table_load(context, path, &table);
  np_phase_table_clear(&table);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  test_fixture *f = *state;
  test_file_write_text(f->path, "cosine,value\n-1,0.0795775\n1,0.0795775\n");
  assert_survives_failed_allocations(load_table, f->path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kind_has_an_example),
      cmocka_unit_test(every_kind_integrates_to_one),
      cmocka_unit_test(mean_cosine_and_moments_agree_with_quadrature),
      cmocka_unit_test(droplets_have_the_published_mean_cosine),
      cmocka_unit_test(droplets_have_the_known_peak),
      cmocka_unit_test(haze_has_its_mean_and_an_aureole),
      cmocka_unit_test(negative_g_is_the_mirror_image),
      cmocka_unit_test(narrow_peaks_keep_their_digits),
      cmocka_unit_test(samples_follow_the_function),
      cmocka_unit_test(sample_value_is_eval),
      cmocka_unit_test(extremes_give_finite_unit_directions),
      cmocka_unit_test(a_backward_peak_is_finite_past_its_end),
      cmocka_unit_test(broadening_ends_isotropic),
      cmocka_unit_test_setup_teardown(a_fine_table_is_its_function, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_coarse_table_is_linear_in_the_cosine, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(wrong_tables_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
