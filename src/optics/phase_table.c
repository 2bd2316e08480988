/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of phase functions. With p linear in the versine v between rows, all else is exact: the integral 2π∫p dv is
 * the trapezium rule's, and its inverse is the root of a quadratic. */
#include "optics/phase_table.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/csv.h"
#include "core/units.h"

static const double integral_error_max = 0.01;

/* ---- Reading ---- */

/* Versine 1 − cosθ; angles by 2·sin²(θ/2), which is exact in a narrow peak. */
static double compute_versine(double position, bool is_angle) {
  const double sine = sin(0.5 * position * NP_DEGREE);
  return is_angle ? 2.0 * sine * sine : 1.0 - position;
}

static neph_result fail_order(const np_csv *csv, size_t row, const char *name) {
  return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s:%u: %s must run from %s to %s, or back, each row further on",
                 csv->path, csv->rows[row].line, name, *name == 'a' ? "0" : "1", *name == 'a' ? "180" : "-1");
}

/* Reads rows in ascending versine, whichever order the file has. */
static neph_result read_rows(const np_csv *csv, int position_column, int value_column, np_phase_table *out) {
  const bool is_angle = csv->field_list[position_column][0] == 'a';
  double first = 0.0, last = 0.0;
  const double low = is_angle ? 0.0 : -1.0, high = is_angle ? 180.0 : 1.0;
  neph_result result = np_csv_get_real(csv, 0, position_column, low, high, &first);
  if (!result) result = np_csv_get_real(csv, csv->row_count - 1, position_column, low, high, &last);
  const bool is_reversed = compute_versine(first, is_angle) > compute_versine(last, is_angle);
  for (unsigned i = 0; !result && i < out->count; i++) {
    const size_t row = is_reversed ? out->count - 1 - i : i;
    double position, value;
    result = np_csv_get_real(csv, row, position_column, low, high, &position);
    if (!result) result = np_csv_get_real(csv, row, value_column, 0.0, 1e30, &value);
    if (result) return result;
    out->versine[i] = (float)compute_versine(position, is_angle);
    out->value[i] = (float)value;
    const bool is_end = i == 0 || i + 1 == out->count;
    if ((is_end && out->versine[i] != (i ? 2.0f : 0.0f)) || (i && !(out->versine[i] > out->versine[i - 1])))
      return fail_order(csv, row, csv->field_list[position_column]);
  }
  return result;
}

static neph_result allocate(neph_context *context, size_t count, np_phase_table *out) {
  out->count = (unsigned)count;
  out->versine = np_alloc(context, count, sizeof *out->versine);
  out->value = np_alloc(context, count, sizeof *out->value);
  out->cumulative = np_alloc(context, count, sizeof *out->cumulative);
  return out->versine && out->value && out->cumulative ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result read_table(const np_csv *csv, np_phase_table *out) {
  int position = np_csv_search_column(csv, "angle_deg");
  if (position == NP_CSV_NO_COLUMN) position = np_csv_search_column(csv, "cosine");
  const int value = np_csv_search_column(csv, "value");
  if (position == NP_CSV_NO_COLUMN || value == NP_CSV_NO_COLUMN)
    return np_fail(csv->context, NEPH_ERROR_BAD_FILE,
                   "%s:%u: a phase function needs the columns value and angle_deg or cosine", csv->path,
                   csv->header.line);
  if (csv->row_count < 2 || csv->row_count > 1000000)
    return np_fail(csv->context, NEPH_ERROR_BAD_FILE, "%s: has %zu rows, must have 2 to 1000000", csv->path,
                   csv->row_count);
  neph_result result = allocate(csv->context, csv->row_count, out);
  return result ? result : read_rows(csv, position, value, out);
}

/* ---- Normalising ---- */

/* 2π∫p dv over one interval. */
static double integrate_interval(const np_phase_table *table, unsigned i) {
  const double width = (double)table->versine[i + 1] - (double)table->versine[i];
  return NP_PI * width * ((double)table->value[i] + (double)table->value[i + 1]);
}

static double accumulate(np_phase_table *table) {
  for (unsigned i = 0; i + 1 < table->count; i++)
    table->cumulative[i + 1] = table->cumulative[i] + integrate_interval(table, i);
  assert(table->versine[0] == 0.0f && table->versine[table->count - 1] == 2.0f);
  return table->cumulative[table->count - 1];
}

static void normalize(double integral, np_phase_table *table) {
  for (unsigned i = 0; i < table->count; i++) {
    table->value[i] = (float)((double)table->value[i] / integral);
    table->cumulative[i] /= integral;
  }
}

static neph_result normalize_file(const char *path, np_phase_table *table) {
  const double integral = accumulate(table);
  if (!(fabs(integral - 1.0) <= integral_error_max))
    return np_fail(table->context, NEPH_ERROR_BAD_FILE,
                   "%s: the phase function integrates to %.6g over the sphere, must be 1 within 1 %%", path, integral);
  normalize(integral, table);
  return NEPH_OK;
}

neph_result np_phase_table_load(neph_context *context, const char *path, np_phase_table *out_table) {
  *out_table = (np_phase_table){.context = context};
  np_csv csv;
  neph_result result = np_csv_load(context, path, &csv);
  if (result) return result;
  result = read_table(&csv, out_table);
  if (!result) result = normalize_file(path, out_table);
  np_csv_clear(&csv);
  if (result) np_phase_table_clear(out_table);
  return result;
}

void np_phase_table_clear(np_phase_table *table) {
  np_alloc_free(table->context, table->versine);
  np_alloc_free(table->context, table->value);
  np_alloc_free(table->context, table->cumulative);
  *table = (np_phase_table){.context = table->context};
}

neph_result np_phase_table_make(neph_context *context, unsigned count, const float *versine, const float *value,
                                np_phase_table *out_table) {
  *out_table = (np_phase_table){.context = context};
  const neph_result result = allocate(context, count, out_table);
  if (result) {
    np_phase_table_clear(out_table);
    return result;
  }
  memcpy(out_table->versine, versine, count * sizeof *versine);
  memcpy(out_table->value, value, count * sizeof *value);
  normalize(accumulate(out_table), out_table);
  return NEPH_OK;
}

/* ---- Use ---- */

/* Sampling inside an interval of width h, with p = p₀ + s·x: p₀x + ½s·x² = c has the root x = 2c/(p₀ + √(p₀² + 2sc)),
 * without cancellation. */
double np_phase_table_sample(const np_phase_table *table, double u) {
  assert(table->count >= 2 && 0.0 <= u && u <= 1.0);
  unsigned low = 0, high = table->count - 1;
  while (high - low > 1) {
    const unsigned middle = (low + high) / 2;
    if (table->cumulative[middle] <= u)
      low = middle;
    else
      high = middle;
  }
  const double width = (double)table->versine[high] - (double)table->versine[low];
  const double value = (double)table->value[low], slope = ((double)table->value[high] - value) / width;
  const double share = (u - table->cumulative[low]) / (2.0 * NP_PI);
  const double root = sqrt(fmax(0.0, value * value + 2.0 * slope * share));
  const double x = value + root > 0.0 ? 2.0 * share / (value + root) : width;
  return (double)table->versine[low] + fmin(fmax(x, 0.0), width);
}

/* Adds weight·P_l(μ) for every l. */
static void add_legendre(double mu, double weight, unsigned count, double *moments) {
  double previous = 0.0, current = 1.0;
  for (unsigned l = 0; l < count; l++) {
    moments[l] += weight * current;
    const double next = ((2.0 * l + 1.0) * mu * current - l * previous) / (l + 1.0);
    previous = current;
    current = next;
  }
}

/* Four Gauss points on each piece of an interval, over which no P_l turns by more than a radian. */
void np_phase_table_get_moments(const np_phase_table *table, unsigned count, double *out_moments) {
  static const double node[4] = {0.069431844202973712, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
  static const double weight[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
  for (unsigned l = 0; l < count; l++) out_moments[l] = 0.0;
  for (unsigned i = 0; i + 1 < table->count; i++) {
    const double begin = (double)table->versine[i], width = (double)table->versine[i + 1] - begin;
    const double angle = acos(1.0 - begin - width) - acos(1.0 - begin);
    const unsigned pieces = (unsigned)(angle * count) + 1;
    for (unsigned k = 0; k < 4 * pieces; k++) {
      const double t = (k / 4 + node[k % 4]) / pieces;
      const double p = (double)table->value[i] + t * ((double)table->value[i + 1] - (double)table->value[i]);
      add_legendre(1.0 - begin - t * width, 2.0 * NP_PI * p * weight[k % 4] * width / pieces, count, out_moments);
    }
  }
}
