/* SPDX-License-Identifier: Apache-2.0 */
/* Chebyshev polynomials through the roots of the first one left out (Press et al. 2007, "Numerical Recipes", section
 * 5.8), in two dimensions; the inverse by Newton's iteration, which starts in the middle of a map that is nearly even.
 */
#include "terrain/field_chart.h"

#include <math.h>

#include "core/units.h"

static double get_node(int k) { return cos(NP_PI * (k + 0.5) / NP_CHART_TERMS); }

void np_field_chart_get_nodes(double columns, double rows, np_field_position out_nodes[NP_CHART_NODES]) {
  for (int j = 0; j < NP_CHART_TERMS; j++)
    for (int i = 0; i < NP_CHART_TERMS; i++)
      out_nodes[j * NP_CHART_TERMS + i] =
          (np_field_position){0.5 * (1.0 + get_node(i)) * columns, 0.5 * (1.0 + get_node(j)) * rows};
}

/* Weight of the value at node k in the coefficient of a degree. */
static double get_weight(int degree, int k) {
  return (degree ? 2.0 : 1.0) / NP_CHART_TERMS * cos(NP_PI * degree * (k + 0.5) / NP_CHART_TERMS);
}

static np_chart_direction add_scaled(np_chart_direction a, double s, np_chart_direction b) {
  return (np_chart_direction){a.east + s * b.east, a.north + s * b.north};
}

static np_chart_direction fit_term(const np_chart_direction directions[NP_CHART_NODES], int row, int column) {
  np_chart_direction sum = {0.0, 0.0};
  for (int j = 0; j < NP_CHART_TERMS; j++)
    for (int i = 0; i < NP_CHART_TERMS; i++)
      sum = add_scaled(sum, get_weight(row, j) * get_weight(column, i), directions[j * NP_CHART_TERMS + i]);
  return sum;
}

np_field_chart np_field_chart_make(double columns, double rows, const np_chart_direction directions[NP_CHART_NODES]) {
  np_field_chart chart = {.columns = columns, .rows = rows};
  for (int row = 0; row < NP_CHART_TERMS; row++)
    for (int column = 0; column < NP_CHART_TERMS; column++)
      chart.terms[row][column] = fit_term(directions, row, column);
  return chart;
}

np_chart_basis np_field_chart_get_basis(double position, double last) {
  const double place = 2.0 * position / last - 1.0, t = np_clamp(place, -1.0, 1.0), beyond = place - t;
  np_chart_basis basis = {.value = {1.0, t}, .slope = {0.0, 1.0}};
  for (int k = 1; k + 1 < NP_CHART_TERMS; k++) {
    basis.value[k + 1] = 2.0 * t * basis.value[k] - basis.value[k - 1];
    basis.slope[k + 1] = 2.0 * (basis.value[k] + t * basis.slope[k]) - basis.slope[k - 1];
  }
  for (int k = 0; k < NP_CHART_TERMS; k++) {
    basis.value[k] += beyond * basis.slope[k];
    basis.slope[k] *= 2.0 / last;
  }
  return basis;
}

static np_chart_row sum_rows(const np_field_chart *chart, const double weights[NP_CHART_TERMS]) {
  np_chart_row row = {.terms = {{0.0, 0.0}}};
  for (int j = 0; j < NP_CHART_TERMS; j++)
    for (int i = 0; i < NP_CHART_TERMS; i++) row.terms[i] = add_scaled(row.terms[i], weights[j], chart->terms[j][i]);
  return row;
}

static np_chart_direction sum_columns(const np_chart_row *row, const double weights[NP_CHART_TERMS]) {
  np_chart_direction sum = {0.0, 0.0};
  for (int i = 0; i < NP_CHART_TERMS; i++) sum = add_scaled(sum, weights[i], row->terms[i]);
  return sum;
}

np_chart_row np_field_chart_get_row(const np_field_chart *chart, double row) {
  const np_chart_basis basis = np_field_chart_get_basis(row, chart->rows);
  return sum_rows(chart, basis.value);
}

np_chart_direction np_chart_row_eval(const np_chart_row *row, const np_chart_basis *column) {
  return sum_columns(row, column->value);
}

np_chart_direction np_field_chart_eval(const np_field_chart *chart, np_field_position position) {
  const np_chart_row row = np_field_chart_get_row(chart, position.row);
  const np_chart_basis column = np_field_chart_get_basis(position.column, chart->columns);
  return np_chart_row_eval(&row, &column);
}

/* One Newton step; returns its length in samples, NaN where the map folds. */
static double improve(const np_field_chart *chart, np_chart_direction direction, np_field_position *position) {
  const np_chart_basis columns = np_field_chart_get_basis(position->column, chart->columns);
  const np_chart_basis rows = np_field_chart_get_basis(position->row, chart->rows);
  const np_chart_row row = sum_rows(chart, rows.value), row_slope = sum_rows(chart, rows.slope);
  const np_chart_direction at = sum_columns(&row, columns.value);
  const np_chart_direction by_column = sum_columns(&row, columns.slope);
  const np_chart_direction by_row = sum_columns(&row_slope, columns.value);
  const double east = direction.east - at.east, north = direction.north - at.north;
  const double area = by_column.east * by_row.north - by_column.north * by_row.east;
  const double column_step = (east * by_row.north - north * by_row.east) / area;
  const double row_step = (by_column.east * north - by_column.north * east) / area;
  position->column += column_step;
  position->row += row_step;
  return fabs(column_step) + fabs(row_step);
}

bool np_field_chart_locate(const np_field_chart *chart, np_chart_direction direction, np_field_position *out_position) {
  *out_position = (np_field_position){0.5 * chart->columns, 0.5 * chart->rows};
  double step = INFINITY;
  for (int round = 0; round < 12 && step > 1e-7 && isfinite(out_position->column + out_position->row); round++)
    step = improve(chart, direction, out_position);
  return step <= 1e-3;
}
