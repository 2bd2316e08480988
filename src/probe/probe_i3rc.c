/* SPDX-License-Identifier: Apache-2.0 */
/* Domain means and columns of the I3RC cases beside the consensus of its participants (probe/i3rc_case.h).
 *
 * The consensus is a mean over Monte Carlo codes, whose own noise its files do not state. It is estimated from third
 * differences along x, which for noise of the same σ in all columns have the standard deviation √20·σ: σ is their
 * median magnitude over 0.6745·√20. A field that is rough from column to column adds to it, so that it is too large
 * rather than too small. A systematic difference between the codes is not in it. */
#include <nephos/probe.h>

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "core/units.h"
#include "probe/i3rc_case.h"
#include "probe/probe_run.h"

/* ---- Quantities ---- */

typedef struct i3rc_quantity {
  const char *name; /* in names of files */
  np_plane_kind kind;
  bool is_at_top, is_up;
  float travel[3]; /* direction of travel of a radiance */
} i3rc_quantity;

#define SINE 0.8660254f

static const i3rc_quantity quantities[] = {
    {"R", NP_PLANE_FLUX, true, true, {0, 0, 0}},
    {"T", NP_PLANE_FLUX, false, false, {0, 0, 0}},
    {"A", NP_PLANE_ABSORBED, false, false, {0, 0, 0}},
    {"Iu", NP_PLANE_RADIANCE, true, true, {0, 0, 1}},
    {"Id", NP_PLANE_RADIANCE, false, false, {0, 0, -1}},
    {"I601", NP_PLANE_RADIANCE, true, true, {SINE, 0, 0.5f}},
    {"I602", NP_PLANE_RADIANCE, true, true, {-SINE, 0, 0.5f}},
};

enum { QUANTITIES = sizeof quantities / sizeof *quantities, OF_R = 0, OF_T = 1, OF_A = 2, CASES = 2 };

static const int case_numbers[CASES] = {1, 3};

/* One row of the output. */
typedef struct i3rc_row {
  int number, experiment;
  const char *quantity;
  unsigned ray_count;
  double value, error;
  bool has_consensus;
  double consensus, consensus_error;
  unsigned column_count;
  double column_rms, column_noise; /* rms of the differences of columns, and its part by noise */
} i3rc_row;

typedef struct i3rc_probe {
  neph_context *context;
  const char *folder;
  neph_probe_desc desc;
  np_monitor monitor;
  unsigned row_count;
  i3rc_row rows[CASES * NP_I3RC_EXPERIMENTS * (QUANTITIES + 1)];
  np_plane_answer *columns; /* room for the columns of a field */
  double *consensus, *scratch;
} i3rc_probe;

/* ---- Consensus ---- */

static char *name_consensus(const i3rc_probe *p, int number, int experiment, const char *quantity) {
  return np_alloc_printf(p->context, "%s/I3RC_cons_res_case%d_exp%d_%s.txt", p->folder, number, experiment, quantity);
}

static bool has_consensus(const i3rc_probe *p, int number, int experiment, const char *quantity) {
  char *path = name_consensus(p, number, experiment, quantity);
  const bool has_file = path && np_file_exists(path);
  np_alloc_free(p->context, path);
  return has_file;
}

static bool has_any(const i3rc_probe *p, int number, int experiment) {
  bool is_any = false;
  for (int q = 0; q < QUANTITIES; q++) is_any = is_any || has_consensus(p, number, experiment, quantities[q].name);
  return is_any;
}

static int compare_reals(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Standard deviation of the noise of columns; `scratch` has room for all of them. */
static double estimate_noise(const double *values, const unsigned columns[2], double *scratch) {
  static const double median_of_normal = 0.6745;
  size_t count = 0;
  for (unsigned j = 0; j < columns[1]; j++)
    for (unsigned i = 0; i + 3 < columns[0]; i++) {
      const double *v = values + (size_t)j * columns[0] + i;
      scratch[count++] = fabs(v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0]);
    }
  if (!count) return 0.0;
  qsort(scratch, count, sizeof *scratch, compare_reals);
  return scratch[count / 2] / (median_of_normal * sqrt(20.0));
}

static void compare_columns(const i3rc_probe *p, double scale, double noise, i3rc_row *row) {
  double squares = 0.0, expected = 0.0;
  for (unsigned c = 0; c < row->column_count; c++) {
    const double own = scale * p->columns[c].value[0], error = scale * p->columns[c].error[0];
    squares += (own - p->consensus[c]) * (own - p->consensus[c]);
    expected += error * error + noise * noise;
  }
  row->column_rms = sqrt(squares / row->column_count);
  row->column_noise = sqrt(expected / row->column_count);
}

static neph_result compare_row(const i3rc_probe *p, const unsigned columns[2], double scale, i3rc_row *row) {
  char *path = name_consensus(p, row->number, row->experiment, row->quantity);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_i3rc_read_numbers(p->context, path, row->column_count, p->consensus);
  np_alloc_free(p->context, path);
  if (result) return result;
  const double noise = estimate_noise(p->consensus, columns, p->scratch);
  for (unsigned c = 0; c < row->column_count; c++) row->consensus += p->consensus[c] / row->column_count;
  row->has_consensus = true;
  row->consensus_error = noise / sqrt(row->column_count);
  compare_columns(p, scale, noise, row);
  return NEPH_OK;
}

/* ---- Measures ---- */

/* Distance from the cloud at which planes lie that touch it. */
static const double clearance_m = 0.01;

static np_plane_query make_query(const np_i3rc_field *field, const i3rc_quantity *quantity) {
  np_plane_query q = {.kind = quantity->kind,
                      .box_max_m = {field->size[0] * field->voxel_m[0], field->size[1] * field->voxel_m[1]},
                      .low_m = field->ground_m - clearance_m,
                      .high_m = field->top_m,
                      .is_up = quantity->is_up,
                      .travel = {quantity->travel[0], quantity->travel[1], quantity->travel[2]}};
  if (quantity->is_at_top) q.low_m = field->top_m + clearance_m;
  if (quantity->kind == NP_PLANE_ABSORBED) q.low_m = field->base_m;
  np_i3rc_field_get_columns(field, q.columns);
  return q;
}

static neph_result measure_quantity(i3rc_probe *p, const np_i3rc_field *field, const np_i3rc_world *world, int q,
                                    i3rc_row *row) {
  const np_plane_query query = make_query(field, &quantities[q]);
  const double scale = query.kind == NP_PLANE_RADIANCE ? NP_PI : 1.0;
  const uint32_t stream = (uint32_t)((row->number * 10 + row->experiment) * 10 + q);
  np_plane_answer whole;
  row->column_count = query.columns[0] * query.columns[1];
  neph_result result =
      np_plane_measure_to_target(np_i3rc_world_get_source(world), &query, p->desc.target_error, p->desc.path_count,
                                 stream, &p->monitor, &row->ray_count, &whole, p->columns);
  if (result) return result;
  row->value = scale * whole.value[0];
  row->error = scale * whole.error[0];
  if (has_consensus(p, row->number, row->experiment, row->quantity)) result = compare_row(p, query.columns, scale, row);
  return result;
}

static i3rc_row *add_row(i3rc_probe *p, int number, int experiment, const char *quantity) {
  i3rc_row *row = &p->rows[p->row_count++];
  *row = (i3rc_row){.number = number, .experiment = experiment, .quantity = quantity};
  return row;
}

/* Light that leaves through the sides of columns: 1 − R − T − A, which is 0 in the mean. */
static void add_horizontal(i3rc_probe *p, int number, int experiment, const i3rc_row *const of[QUANTITIES]) {
  i3rc_row *row = add_row(p, number, experiment, "H");
  row->value = 1.0;
  for (int q = OF_R; q <= OF_A; q++) {
    if (!of[q]) continue;
    row->value -= of[q]->value;
    row->error = hypot(row->error, of[q]->error);
    row->ray_count += of[q]->ray_count;
  }
}

/* Absorption is measured wherever reflected and transmitted light are, for their balance. */
static neph_result measure_experiment(i3rc_probe *p, const np_i3rc_field *field, int number, int experiment) {
  const np_i3rc_experiment *e = &np_i3rc_experiments[experiment - 1];
  const i3rc_row *of[QUANTITIES] = {NULL};
  np_i3rc_world *world;
  neph_result result = np_i3rc_world_create(field, e, p->desc.integrator, p->desc.seed, &world);
  for (int q = 0; q < QUANTITIES && !result; q++) {
    const bool is_balanced = q == OF_A && of[OF_R] && of[OF_T] && e->albedo < 1.0;
    if (!is_balanced && !has_consensus(p, number, experiment, quantities[q].name)) continue;
    i3rc_row *row = add_row(p, number, experiment, quantities[q].name);
    of[q] = row;
    result = measure_quantity(p, field, world, q, row);
  }
  if (!result && of[OF_R] && of[OF_T]) add_horizontal(p, number, experiment, of);
  np_i3rc_world_destroy(world);
  return result;
}

static neph_result allocate_columns(i3rc_probe *p, const np_i3rc_field *field) {
  unsigned columns[2];
  np_i3rc_field_get_columns(field, columns);
  const size_t count = (size_t)columns[0] * columns[1];
  p->columns = np_alloc(p->context, count, sizeof *p->columns);
  p->consensus = np_alloc(p->context, count, sizeof *p->consensus);
  p->scratch = np_alloc(p->context, count, sizeof *p->scratch);
  return p->columns && p->consensus && p->scratch ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void free_columns(i3rc_probe *p) {
  np_alloc_free(p->context, p->columns);
  np_alloc_free(p->context, p->consensus);
  np_alloc_free(p->context, p->scratch);
}

static neph_result measure_case(i3rc_probe *p, int c) {
  const int number = case_numbers[c];
  np_i3rc_field field = {0};
  bool is_any = false;
  for (int e = 1; e <= NP_I3RC_EXPERIMENTS; e++) is_any = is_any || has_any(p, number, e);
  if (!is_any) return NEPH_OK;
  neph_result result = np_i3rc_field_create(p->context, number, p->folder, &field);
  if (!result) result = allocate_columns(p, &field);
  for (int e = 1; e <= NP_I3RC_EXPERIMENTS && !result; e++) {
    const double done = ((double)c * NP_I3RC_EXPERIMENTS + e - 1.0) / (CASES * NP_I3RC_EXPERIMENTS);
    np_monitor_set_range(&p->monitor, done, done + 1.0 / (CASES * NP_I3RC_EXPERIMENTS));
    if (has_any(p, number, e)) result = measure_experiment(p, &field, number, e);
  }
  free_columns(p);
  np_i3rc_field_clear(&field);
  return result;
}

static neph_result measure_all(i3rc_probe *p) {
  np_monitor_set_stage(&p->monitor, "probing I3RC");
  neph_result result = NEPH_OK;
  for (int c = 0; c < CASES && !result; c++) result = measure_case(p, c);
  if (result || p->row_count) return result;
  return np_fail(p->context, NEPH_ERROR_NOT_FOUND,
                 "%s: holds no results of the I3RC: must hold files such as I3RC_cons_res_case1_exp1_R.txt", p->folder);
}

/* ---- Output ---- */

static void print_consensus(FILE *out, const i3rc_row *r) {
  const double sigma = hypot(r->error, r->consensus_error), difference = r->value - r->consensus;
  fprintf(out, "%.6g,%.3g,%.3g,%.3g,%u,%.4g,%.4g\n", r->consensus, r->consensus_error,
          sigma > 0.0 ? difference / sigma : 0.0, 100.0 * difference / r->consensus, r->column_count, r->column_rms,
          r->column_noise);
}

static void print_rows(FILE *out, const void *user) {
  const i3rc_probe *p = user;
  fputs("case,experiment,quantity,integrator,rays,value,se,consensus,consensus_se,sigmas,percent,columns,column_rms,"
        "column_noise\n",
        out);
  for (unsigned i = 0; i < p->row_count; i++) {
    const i3rc_row *r = &p->rows[i];
    fprintf(out, "%d,%d,%s,%s,%u,%.6g,%.3g,", r->number, r->experiment, r->quantity,
            p->desc.integrator == NEPH_INTEGRATOR_PATH ? "path" : "march", r->ray_count, r->value, r->error);
    if (r->has_consensus)
      print_consensus(out, r);
    else
      fputs(",,,,,,\n", out);
  }
}

static neph_result check_desc(neph_context *context, const neph_probe_desc *desc) {
  if (desc->path_count < 1)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: path_count is 0, must be at least 1");
  if (!(desc->target_error > 0.0))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "probe: target_error is %g, must be above 0",
                   desc->target_error);
  return NEPH_OK;
}

neph_result neph_probe_i3rc(neph_context *context, const char *folder, const neph_probe_desc *desc, char **out_text) {
  if (NP_LACKS_OUT(context, out_text, folder)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  const neph_probe_desc defaults = NEPH_PROBE_DESC_DEFAULT;
  i3rc_probe *p = np_alloc(context, 1, sizeof *p);
  if (!p) return NEPH_ERROR_OUT_OF_MEMORY;
  p->context = context;
  p->folder = folder;
  neph_result result = np_desc_read(context, "neph_probe_desc", &defaults, sizeof defaults, desc, &p->desc);
  if (!result) result = check_desc(context, &p->desc);
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&p->monitor, context, p->desc.progress, p->desc.progress_user);
  if (!result) result = measure_all(p);
  if (!result) result = np_probe_write_text(context, print_rows, p, out_text);
  np_float_mode_leave(mode);
  np_alloc_free(context, p);
  return result == NEPH_ERROR_BAD_FILE ? NEPH_ERROR_BAD_SCENE : result;
}
