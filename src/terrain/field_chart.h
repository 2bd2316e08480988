/* SPDX-License-Identifier: Apache-2.0 */
/* Places of the samples of a grid that is even in some map projection, as polynomials.
 *
 * A chart gives the direction from the planet's centre, in the world's frame, of each position in a field. Projections
 * are smooth: Chebyshev polynomials of twelve terms along each axis hold one over a thousand kilometres within a
 * millimetre, wherever on the globe it lies.
 */
#ifndef NP_TERRAIN_FIELD_CHART_H
#define NP_TERRAIN_FIELD_CHART_H

#include "core/math.h"

enum { NP_CHART_TERMS = 12, NP_CHART_NODES = NP_CHART_TERMS * NP_CHART_TERMS };

/* Position in a height field: samples east of the western column and north of the southern row. */
typedef struct np_field_position {
  double column, row;
} np_field_position;

/* Components of a unit direction from the planet's centre: east and north. */
typedef struct np_chart_direction {
  double east, north;
} np_chart_direction;

typedef struct np_field_chart {
  double columns, rows;                                     /* last position along each axis; the first is 0 */
  np_chart_direction terms[NP_CHART_TERMS][NP_CHART_TERMS]; /* coefficients by the row's degree, then the column's */
} np_field_chart;

/* Values of the polynomials at one position along an axis; beyond its ends they continue linearly. */
typedef struct np_chart_basis {
  double value[NP_CHART_TERMS], slope[NP_CHART_TERMS];
} np_chart_basis;

/* A chart restricted to one row. */
typedef struct np_chart_row {
  np_chart_direction terms[NP_CHART_TERMS];
} np_chart_row;

/* Positions whose directions define a chart of a field of this size. */
void np_field_chart_get_nodes(double columns, double rows, np_field_position out_nodes[NP_CHART_NODES]);

np_field_chart np_field_chart_make(double columns, double rows, const np_chart_direction directions[NP_CHART_NODES]);

np_chart_basis np_field_chart_get_basis(double position, double last);
np_chart_row np_field_chart_get_row(const np_field_chart *chart, double row);
np_chart_direction np_chart_row_eval(const np_chart_row *row, const np_chart_basis *column);
np_chart_direction np_field_chart_eval(const np_field_chart *chart, np_field_position position);

/* The position with a given direction; false where there is none. */
bool np_field_chart_locate(const np_field_chart *chart, np_chart_direction direction, np_field_position *out_position);

#endif
