/* SPDX-License-Identifier: Apache-2.0 */
/* Columns of a field before any noise, and bounds of their values over boxes. */
#ifndef NP_CLOUD_CLOUD_COLUMN_H
#define NP_CLOUD_CLOUD_COLUMN_H

#include "cloud/cloud_model.h"

typedef struct np_cloud_column {
  float x_m, y_m;        /* position at the base, without skew */
  float strength, anvil; /* strength of tower and anvil, as depth: 1 in the centre of the largest cell */
  float base_m, thickness_m, type, rain, age; /* values of this column; `rain` is a share */
} np_cloud_column;

/* Column through a position of the field. */
np_cloud_column np_cloud_column_compute(const np_cloud_model *model, float x_m, float y_m, float height_m);

/* Share of the column's thickness up to its top. */
float np_cloud_column_compute_top(const np_cloud_model *model, const np_cloud_column *column);

/* Columns that intersect a box, without skew. */
typedef struct np_cloud_columns {
  const np_cloud_box *box;
  float min_m[2], max_m[2];
} np_cloud_columns;

/* Columns that intersect a box between two heights. */
np_cloud_columns np_cloud_columns_make(const np_cloud_model *model, const np_cloud_box *box, float low_m, float high_m);

/* Upper bounds of the strength and the anvil of the columns. */
float np_cloud_columns_bound_strength(const np_cloud_model *model, const np_cloud_columns *columns);
float np_cloud_columns_bound_anvil(const np_cloud_model *model, const np_cloud_columns *columns);

/* Range of a quantity of the picture; `fallback` if the picture lacks it. */
np_interval np_cloud_columns_bound_plane(const np_cloud_model *model, const np_cloud_columns *columns,
                                         neph_cloud_map_quantity quantity, float fallback);

/* Range of heights above the columns' bases over their thicknesses, clamped to [0, 1]. False: no height of the box is
 * inside. */
bool np_cloud_columns_bound_shares(const np_cloud_model *model, const np_cloud_columns *columns, float low_m,
                                   float high_m, np_interval *out_shares);

#endif
