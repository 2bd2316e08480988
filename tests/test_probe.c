/* SPDX-License-Identifier: Apache-2.0 */
/* The tracer against discrete ordinates (tests/data/slab_flux.csv, slab_radiance.csv), through the probe.
 *
 * test_probe                      a selection, to a standard error of 0.5 % where seconds suffice
 * test_probe long                 every row up to a depth of 1024, to 0.1 %, and a dozen to 0.01 %: many hours
 * test_probe long NAME [FACTOR]   of these the groups whose name matches NAME, in which * and ? stand for anything,
 *                                 to FACTOR times the errors, in FACTOR² times less time
 */
#include <limits.h>

#include "test_probes.h"
#include "test_shards.h"

/* ---- Judging answers ---- */

enum { WORST_COUNT = 5 };

/* An answer against the table's value. */
typedef struct judgement {
  const char *name;
  size_t row;
  double z, relative_error;
} judgement;

typedef struct verdict {
  unsigned count;
  double chi_square, relative_error_max;
  judgement worst[WORST_COUNT]; /* the largest |z| first */
} verdict;

/* Keeps an answer if it is among the worst. */
static void keep_worst(judgement worst[WORST_COUNT], judgement answer) {
  for (int i = 0; i < WORST_COUNT; i++) {
    if (worst[i].name && fabs(answer.z) <= fabs(worst[i].z)) continue;
    const judgement better = worst[i];
    worst[i] = answer;
    answer = better;
  }
}

/* One answer against the table's value, which is that of a `part` that is scattered. */
static void judge(verdict *v, const np_csv *csv, size_t row, const char *names[3], double part) {
  const double expected = get(csv, row, names[0]), actual = get(csv, row, names[1]), error = get(csv, row, names[2]);
  const double z = (actual - expected) / error;
  keep_worst(v->worst, (judgement){names[0], row, z, error / part});
  v->count++;
  v->chi_square += z * z;
  v->relative_error_max = fmax(v->relative_error_max, error / part);
}

static void print_verdict(const np_csv *csv, const verdict *v) {
  print_message("%u answers: mean of z squared %.2f, largest relative standard error %.2g; the worst:\n", v->count,
                v->chi_square, v->relative_error_max);
  for (int i = 0; i < WORST_COUNT && v->worst[i].name; i++)
    print_message("  %s: z = %.2f, relative standard error %.2g: %.50s\n", v->worst[i].name, v->worst[i].z,
                  v->worst[i].relative_error, csv->rows[v->worst[i].row].text);
}

static void judge_answers(const fixture *f, bool is_flux, verdict *v) {
  static const char *names[3][3] = {{"R", "R_out", "R_se"}, {"T", "T_out", "T_se"}, {"L", "L_out", "L_se"}};
  np_csv csv;
  *v = (verdict){0};
  assert_int_equal(np_csv_load(f->context, f->answers, &csv), NEPH_OK);
  for (size_t row = 0; row < csv.row_count; row++) {
    if (!is_flux) {
      judge(v, &csv, row, names[2], get(&csv, row, "L"));
      continue;
    }
    judge(v, &csv, row, names[0], get(&csv, row, "R"));
    judge(v, &csv, row, names[1], get(&csv, row, "T") - get(&csv, row, "T_unscattered"));
  }
  v->chi_square /= v->count;
  print_verdict(&csv, v);
  np_csv_clear(&csv);
}

/* Factor on all target errors: to see long runs through in a part of their time. */
static double error_factor = 1.0;

/* No answer further off than four standard errors, of which one in 16,000 is by chance; and the mean of z² within four
 * of its own standard errors of 1, which it leaves when errors are stated too small or too large. The pilot knows its
 * own error to a tenth or, where contributions are rare, a third. */
static void assert_right(const fixture *f, bool is_flux, unsigned count_min, double target_error) {
  verdict v;
  judge_answers(f, is_flux, &v);
  assert_true(v.count >= count_min);
  assert_true(fabs(v.worst[0].z) <= 4.0);
  assert_near(v.chi_square, 1.0, 4.0 * sqrt(2.0 / v.count));
  assert_true(v.relative_error_max <= 1.5 * error_factor * target_error);
}

/* ---- Tests ---- */

/* Probes the picked rows of a table, each answer to `target_error` or by `path_count` paths. */
static void probe_rows(const fixture *f, const char *table, const pick *picks, size_t count, unsigned path_count,
                       double target_error, neph_path_guiding path_guiding) {
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_guiding = path_guiding;
  desc.path_count = path_count;
  desc.target_error = error_factor * target_error;
  write_cases(f, table, picks, count);
  run_probe(f, &desc);
}

static void probe_picks(const fixture *f, const char *table, const pick *picks, size_t count, unsigned path_count,
                        double target_error) {
  probe_rows(f, table, picks, count, path_count, target_error, NEPH_PATH_GUIDING_NONE);
}

/* The same with paths that are guided by the march's solution. */
static void probe_guided_picks(const fixture *f, const char *table, const pick *picks, size_t count,
                               unsigned path_count, double target_error) {
  probe_rows(f, table, picks, count, path_count, target_error, NEPH_PATH_GUIDING_ADJOINT);
}

static void fluxes_are_those_of_discrete_ordinates(void **state) {
  static const pick picks[] = {
      {"0", "1", "1e-08", NULL, NULL, NULL},      {"0", "1", "1e-06", NULL, NULL, NULL},
      {"0", "1", "0.0001", NULL, NULL, NULL},     {"0", "1", "0.001", NULL, NULL, NULL},
      {"0", "1", "0.01", NULL, NULL, NULL},       {"0", "0.9", "0.1", NULL, NULL, NULL},
      {"0", "0.9", "0.5", NULL, NULL, NULL},      {"0", "0.9", "1", NULL, NULL, NULL},
      {"0", "0.9", "2", NULL, NULL, NULL},        {"0", "0.99", "0.5", NULL, NULL, NULL},
      {"0", "1", "1", NULL, NULL, NULL},          {"0", "1", "4", "diffuse", NULL, NULL},
      {"0.85", "1", "1e-08", "1", NULL, NULL},    {"0.85", "1", "1e-06", "1", NULL, NULL},
      {"0.85", "1", "1e-08", "0.5", NULL, NULL},  {"0.85", "1", "2", "diffuse", NULL, NULL},
      {"0.85", "1", "8", "diffuse", NULL, NULL},  {"0.85", "1", "16", "diffuse", NULL, NULL},
      {"0.85", "1", "64", "diffuse", NULL, NULL},
  };
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), 1000000, 5e-3);
  assert_right(*state, true, 2 * 41, 5e-3);
}

/* Slabs that few paths come through, or few turn back in, would take minutes at 0.5 %: fewer paths, whose error is as
 * honest. */
static void fluxes_of_thick_slabs_are_right(void **state) {
  static const pick picks[] = {
      {"0", "1", "16", "1", NULL, NULL},
      {"0.85", "0.99", "16", "diffuse", NULL, NULL},
      {"0.85", "1", "8", "1", NULL, NULL},
      {"0.85", "1", "8", "0.5", NULL, NULL},
  };
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), 8192, NEPH_UNLIMITED);
  assert_right(*state, true, 2 * 4, 0.1);
}

static void radiances_of_isotropic_slabs_are_right(void **state) {
  static const pick picks[] = {
      {"0", NULL, NULL, NULL, "-0.9", "0"},   {"0", NULL, NULL, NULL, "-0.5", "60"},
      {"0", NULL, NULL, NULL, "-0.1", "120"}, {"0", NULL, NULL, NULL, "-0.02", "0"},
      {"0", NULL, NULL, NULL, "0.02", "30"},  {"0", NULL, NULL, NULL, "0.1", "90"},
      {"0", NULL, NULL, NULL, "0.5", "180"},  {"0", NULL, NULL, NULL, "1", "0"},
  };
  probe_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), 1000000, 5e-3);
  assert_right(*state, false, 8, 5e-3);
}

/* Directions at depth 10 that a million paths settle to 0.5 %; the others are of the long runs. */
static void radiances_of_peaked_slabs_are_right(void **state) {
  static const pick picks[] = {
      {"0.75", NULL, NULL, NULL, "-1", "0"},    {"0.75", NULL, NULL, NULL, "-0.5", "90"},
      {"0.75", NULL, NULL, NULL, "-0.1", "90"}, {"0.75", NULL, NULL, NULL, "0.1", "90"},
      {"0.75", NULL, NULL, NULL, "0.5", "90"},  {"0.75", NULL, NULL, NULL, "0.9", "90"},
      {"0.85", NULL, "1", NULL, "-0.9", "0"},   {"0.85", NULL, "1", NULL, "-0.6", "0"},
      {"0.85", NULL, "1", NULL, "-0.6", "60"},  {"0.85", NULL, "1", NULL, "-0.5", "90"},
      {"0.85", NULL, "1", NULL, "-0.3", "30"},  {"0.85", NULL, "1", NULL, "-0.1", "120"},
      {"0.85", NULL, "1", NULL, "0.1", "0"},    {"0.85", NULL, "1", NULL, "0.5", "0"},
      {"0.85", NULL, "1", NULL, "0.3", "90"},   {"0.85", NULL, "1", NULL, "-0.98", "180"},
      {"0.85", NULL, "10", NULL, "0.1", "0"},   {"0.85", NULL, "10", NULL, "0.1", "30"},
      {"0.85", NULL, "10", NULL, "0.3", "0"},   {"0.85", NULL, "10", NULL, "0.5", "30"},
  };
  probe_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), 1000000, 5e-3);
  assert_right(*state, false, 20, 5e-3);
}

/* Transmission of slabs that absorb, down to 7·10⁻⁶ of what falls in, and through white ones of up to 1024: without
 * a solution to be guided by, few paths or none find it. */
static void guided_paths_measure_transmitted_light(void **state) {
  static const pick picks[] = {
      {"0", "0.9", "16", "0.5", NULL, NULL},     {"0", "0.9", "16", "diffuse", NULL, NULL},
      {"0", "0.99", "64", "1", NULL, NULL},      {"0.85", "0.9", "32", "1", NULL, NULL},
      {"0.85", "0.99", "64", "0.5", NULL, NULL}, {"0", "1", "64", "1", NULL, NULL},
      {"0", "1", "1024", "diffuse", NULL, NULL}, {"0.85", "1", "256", "0.5", NULL, NULL},
  };
  probe_guided_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), 32768, NEPH_UNLIMITED);
  assert_right(*state, true, 2 * COUNT(picks), 1e-2);
}

/* ---- Errors of what few paths find, and guiding where it finds more ---- */

static void write_text(const fixture *f, const char *rows) {
  FILE *out = fopen(f->cases, "w");
  assert_non_null(out);
  fprintf(out, "quantity,g,albedo,tau,mu0,mu_view,phi_deg\n%s", rows);
  fclose(out);
}

/* Numbers in the order of the columns; an error may be infinite. */
static void read_answers(const fixture *f, neph_path_guiding path_guiding, double out[][6], size_t count) {
  static const char *const columns[6] = {"R_out", "T_out", "R_se", "T_se", "L_out", "L_se"};
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  np_csv csv;
  desc.path_count = 8192;
  desc.path_guiding = path_guiding;
  run_probe(f, &desc);
  assert_int_equal(np_csv_load(f->context, f->answers, &csv), NEPH_OK);
  assert_int_equal(csv.row_count, count);
  for (size_t row = 0; row < count; row++)
    for (int i = 0; i < 6; i++) {
      const int column = np_csv_search_column(&csv, columns[i]);
      out[row][i] = column == NP_CSV_NO_COLUMN ? 0.0 : strtod(np_csv_get_field(&csv, row, column), NULL);
    }
  np_csv_clear(&csv);
}

/* 8192 unguided paths sample nothing, or next to nothing, of the fluxes through an absorbing slab of depth 64, 7.48e-6
 * and 3.62e-7 (slab_flux.csv). Where nothing can be scattered there is no error, and none is warned of. */
static void errors_of_few_paths_are_not_known(void **state) {
  fixture *f = *state;
  double answers[4][6];
  write_text(f, "flux,0,0.99,64,1,,\nflux,0.85,0.9,64,1,,\nflux,0,0,3,1,,\nflux,0.85,1,0,1,,\n");
  read_answers(f, NEPH_PATH_GUIDING_NONE, answers, 4);
  for (int row = 0; row < 4; row++) {
    const bool is_known = row >= 2;
    assert_int_equal(isinf(answers[row][3]), !is_known);
    assert_true(is_known ? answers[row][2] == 0.0 : answers[row][2] > 0.0 && answers[row][2] < 0.01);
  }
  assert_near_relative(answers[2][1], exp(-3.0), 1e-11); /* twelve digits are written */
  assert_true(answers[3][1] == 1.0);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 2);
  assert_non_null(strstr(f->log.text, "cases.csv:2: T rests on"));
  assert_non_null(strstr(f->log.text, "or guide them"));
}

/* A handful of 8192 paths bring all of an answer: how much their batches differ would say little of how far it is off.
 */
static void few_bright_paths_are_few(void **state) {
  fixture *f = *state;
  double answers[1][6];
  write_text(f, "flux,0,0.9,18,1,,\n"); /* T is 1e-4, by paths of some 0.1 each */
  read_answers(f, NEPH_PATH_GUIDING_NONE, answers, 1);
  assert_true(answers[0][1] > exp(-18.0));
  assert_true(isinf(answers[0][3]));
}

/* Each number is that of guided paths or of others, to the bit: the former deep in what absorbs, where their errors
 * are those of the table, the latter in thin slabs. */
static void paths_are_guided_where_it_pays(void **state) {
  fixture *f = *state;
  double none[5][6], adjoint[5][6], chosen[5][6];
  write_text(f, "flux,0,0.99,64,1,,\nflux,0.85,0.9,64,1,,\nflux,0.85,1,64,diffuse,,\nflux,0.85,1,1,0.5,,\n"
                "radiance_bottom_down,0.85,1,1,0.5,-0.9,120\n");
  static const double transmitted[2] = {7.48181823564e-06, 3.61892042738e-07};
  read_answers(f, NEPH_PATH_GUIDING_NONE, none, 5);
  read_answers(f, NEPH_PATH_GUIDING_ADJOINT, adjoint, 5);
  test_log_clear(&f->log);
  read_answers(f, NEPH_PATH_GUIDING_AUTO, chosen, 5);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  for (int row = 0; row < 3; row++) assert_memory_equal(&chosen[row][1], &adjoint[row][1], sizeof(double));
  for (int row = 0; row < 2; row++) {
    assert_near(chosen[row][1], transmitted[row], 4.0 * chosen[row][3]); /* one in 16,000 by chance */
    assert_true(chosen[row][3] < 0.1 * chosen[row][1]);
  }
  assert_memory_equal(chosen[3], none[3], 4 * sizeof(double));
  assert_memory_equal(&chosen[4][4], &none[4][4], 2 * sizeof(double));
}

static void answers_are_the_same_bits_for_any_threads(void **state) {
  const fixture *f = *state;
  static const pick picks[] = {{"0.85", "0.99", "1", "0.5", NULL, NULL}};
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_count = 1000;
  write_cases(f, "data/slab_flux.csv", picks, 1);
  neph_context *alone = test_context_create(1, NULL);
  for (int i = 0; i < 4; i++) {
    static const neph_path_guiding path_guidings[4] = {NEPH_PATH_GUIDING_NONE, NEPH_PATH_GUIDING_NONE,
                                                       NEPH_PATH_GUIDING_ADJOINT, NEPH_PATH_GUIDING_AUTO};
    char *one, *two;
    desc.integrator = i == 0 ? NEPH_INTEGRATOR_MARCH : NEPH_INTEGRATOR_PATH;
    desc.path_guiding = path_guidings[i];
    assert_int_equal(neph_probe_slab(alone, f->cases, &desc, &one), NEPH_OK);
    assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &two), NEPH_OK);
    assert_string_equal(one, two);
    neph_text_destroy(alone, one);
    neph_text_destroy(f->context, two);
  }
  neph_context_destroy(alone);
}

static void descriptions_are_checked(void **state) {
  fixture *f = *state;
  char *text = NULL;
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_count = 0;
  assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(text);
  assert_one_error(&f->log, "path_count is 0");
  desc.path_count = 1;
  desc.target_error = NAN;
  assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "target_error is nan");
  desc.target_error = NEPH_UNLIMITED;
  desc.path_guiding = (neph_path_guiding)3;
  assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "path_guiding is 3, must be none (0), adjoint (1) or auto (2)");
  desc.path_guiding = NEPH_PATH_GUIDING_NONE;
  desc.target_error = 0.0;
  assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "target_error is 0, must be above 0");
}

static bool refuse(void *user, const neph_progress *progress) {
  (void)user;
  (void)progress;
  return false;
}

static void a_probe_can_be_cancelled(void **state) {
  const fixture *f = *state;
  static const pick picks[] = {{"0", "1", "64", "1", NULL, NULL}};
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_count = 100000000;
  desc.progress = refuse;
  char *text;
  write_cases(f, "data/slab_flux.csv", picks, 1);
  assert_int_equal(neph_probe_slab(f->context, f->cases, &desc, &text), NEPH_ERROR_CANCELLED);
  assert_null(text);
}

static neph_result probe_one(neph_context *context, void *cases) {
  neph_probe_desc desc = NEPH_PROBE_DESC_DEFAULT;
  desc.path_count = 1;
  char *text;
  neph_result result = neph_probe_slab(context, cases, &desc, &text);
  neph_text_destroy(context, text);
  return result;
}

static void failed_allocations_leave_nothing(void **state) {
  const fixture *f = *state;
  static const pick picks[] = {{"0", "1", "1", "1", NULL, NULL}};
  write_cases(f, "data/slab_flux.csv", picks, 1);
  assert_survives_failed_allocations(probe_one, f->cases);
}

/* ---- Long runs ---- */

static void every_flux_of_thin_slabs_to_a_thousandth(void **state) {
  static const pick picks[] = {{.tau = "1e-08"}, {.tau = "1e-06"}, {.tau = "0.0001"}, {.tau = "0.001"}, {.tau = "0.01"},
                               {.tau = "0.1"},   {.tau = "0.5"},   {.tau = "1"},      {.tau = "2"}};
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, true, 2 * 102, 1e-3);
}

static void every_flux_of_depth_4_to_a_thousandth(void **state) {
  static const pick picks[] = {{.tau = "4"}};
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, true, 2 * 18, 1e-3);
}

static void every_flux_of_depth_8_to_a_thousandth(void **state) {
  static const pick picks[] = {{.tau = "8"}};
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, true, 2 * 18, 1e-3);
}

/* Light through a deep slab is sampled by guided paths, some minutes a row; others scatter depth squared times. */
static void probe_deep_fluxes(void **state, const char *g, const char *tau, unsigned row_count) {
  const pick picks[] = {{.g = g, .tau = tau}};
  probe_guided_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, true, 2 * row_count, 1e-3);
}

static void isotropic_fluxes_of_depth_16_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "16", 9); }

static void peaked_fluxes_of_depth_16_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "16", 9); }

static void isotropic_fluxes_of_depth_32_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "32", 9); }

static void peaked_fluxes_of_depth_32_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "32", 9); }

static void isotropic_fluxes_of_depth_64_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "64", 9); }

static void peaked_fluxes_of_depth_64_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "64", 9); }

static void isotropic_fluxes_of_depth_128_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "128", 9); }

static void peaked_fluxes_of_depth_128_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "128", 9); }

static void isotropic_fluxes_of_depth_256_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "256", 3); }

static void peaked_fluxes_of_depth_256_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "256", 3); }

static void isotropic_fluxes_of_depth_1024_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0", "1024", 3); }

static void peaked_fluxes_of_depth_1024_to_a_thousandth(void **state) { probe_deep_fluxes(state, "0.85", "1024", 3); }

static void a_dozen_fluxes_to_a_ten_thousandth(void **state) {
  static const pick picks[] = {
      {"0", "1", "1e-08", "1", NULL, NULL},    {"0", "1", "1e-06", "0.5", NULL, NULL},
      {"0", "1", "0.0001", "1", NULL, NULL},   {"0", "1", "0.001", "0.5", NULL, NULL},
      {"0", "1", "0.01", "1", NULL, NULL},     {"0", "1", "0.01", "0.5", NULL, NULL},
      {"0", "1", "0.1", "1", NULL, NULL},      {"0", "0.9", "0.1", "0.5", NULL, NULL},
      {"0", "0.9", "0.5", "1", NULL, NULL},    {"0.85", "1", "1e-08", "1", NULL, NULL},
      {"0.85", "1", "0.001", "1", NULL, NULL}, {"0.85", "1", "0.01", "1", NULL, NULL},
  };
  probe_picks(*state, "data/slab_flux.csv", picks, COUNT(picks), UINT_MAX, 1e-4);
  assert_right(*state, true, 2 * 12, 1e-4);
}

static void every_isotropic_radiance_to_a_thousandth(void **state) {
  static const pick picks[] = {{.g = "0"}};
  probe_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, false, 210, 1e-3);
}

/* The sun stands in the zenith there: the table's other azimuths repeat these. */
static void every_radiance_of_a_broad_peak_to_a_thousandth(void **state) {
  static const pick picks[] = {{.g = "0.75", .phi_deg = "0"}, {.g = "0.75", .phi_deg = "90"}};
  probe_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, false, 60, 1e-3);
}

static void every_radiance_of_a_sharp_peak_to_a_thousandth(void **state) {
  static const pick picks[] = {{.g = "0.85", .tau = "1"}};
  probe_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, false, 210, 1e-3);
}

/* Those of depth 10, by azimuth: some forty minutes each. */
static void probe_deep_radiances(void **state, const char *phi_deg) {
  const pick picks[] = {{.g = "0.85", .tau = "10", .phi_deg = phi_deg}};
  probe_guided_picks(*state, "data/slab_radiance.csv", picks, COUNT(picks), UINT_MAX, 1e-3);
  assert_right(*state, false, 30, 1e-3);
}

static void deep_radiances_at_azimuth_0_to_a_thousandth(void **state) { probe_deep_radiances(state, "0"); }

static void deep_radiances_at_azimuth_30_to_a_thousandth(void **state) { probe_deep_radiances(state, "30"); }

static void deep_radiances_at_azimuth_60_to_a_thousandth(void **state) { probe_deep_radiances(state, "60"); }

static void deep_radiances_at_azimuth_90_to_a_thousandth(void **state) { probe_deep_radiances(state, "90"); }

static void deep_radiances_at_azimuth_120_to_a_thousandth(void **state) { probe_deep_radiances(state, "120"); }

static void deep_radiances_at_azimuth_150_to_a_thousandth(void **state) { probe_deep_radiances(state, "150"); }

static void deep_radiances_at_azimuth_180_to_a_thousandth(void **state) { probe_deep_radiances(state, "180"); }

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(fluxes_are_those_of_discrete_ordinates, set_up, tear_down),
      cmocka_unit_test_setup_teardown(fluxes_of_thick_slabs_are_right, set_up, tear_down),
      cmocka_unit_test_setup_teardown(radiances_of_isotropic_slabs_are_right, set_up, tear_down),
      cmocka_unit_test_setup_teardown(radiances_of_peaked_slabs_are_right, set_up, tear_down),
      cmocka_unit_test_setup_teardown(guided_paths_measure_transmitted_light, set_up, tear_down),
      cmocka_unit_test_setup_teardown(errors_of_few_paths_are_not_known, set_up, tear_down),
      cmocka_unit_test_setup_teardown(few_bright_paths_are_few, set_up, tear_down),
      cmocka_unit_test_setup_teardown(paths_are_guided_where_it_pays, set_up, tear_down),
      cmocka_unit_test_setup_teardown(answers_are_the_same_bits_for_any_threads, set_up, tear_down),
      cmocka_unit_test_setup_teardown(descriptions_are_checked, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_probe_can_be_cancelled, set_up, tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_leave_nothing, set_up, tear_down),
  };
  const struct CMUnitTest long_tests[] = {
      cmocka_unit_test_setup_teardown(every_flux_of_thin_slabs_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_flux_of_depth_4_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_flux_of_depth_8_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_16_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_16_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_32_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_32_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_64_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_64_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_128_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_128_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_256_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_256_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(isotropic_fluxes_of_depth_1024_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(peaked_fluxes_of_depth_1024_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_dozen_fluxes_to_a_ten_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_isotropic_radiance_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_radiance_of_a_broad_peak_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(every_radiance_of_a_sharp_peak_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_0_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_30_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_60_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_90_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_120_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_150_to_a_thousandth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(deep_radiances_at_azimuth_180_to_a_thousandth, set_up, tear_down),
  };
  test_shard shard;
  if (argc > 1 && test_shard_read(argv[1], &shard)) return test_shard_run(shard, tests, COUNT(tests));
  const bool is_long = argc > 1 && strcmp(argv[1], "long") == 0;
  if (is_long && argc > 2) cmocka_set_test_filter(argv[2]);
  if (is_long && argc > 3) error_factor = strtod(argv[3], NULL);
  return is_long ? cmocka_run_group_tests(long_tests, NULL, NULL) : cmocka_run_group_tests(tests, NULL, NULL);
}
