/* SPDX-License-Identifier: Apache-2.0 */
/* Columns of a field before any noise, and bounds of their values over boxes. */
#ifndef NP_CLOUD_CLOUD_COLUMN_H
#define NP_CLOUD_CLOUD_COLUMN_H

#include "cloud/cloud_model.h"

typedef struct np_cloud_column {
  float x_m, y_m;        /* where it stands at the base: freed from the skew */
  float strength, anvil; /* of the tower and of the anvil, in depth: 1 in the heart of the largest cell */
  float base_m, thickness_m, type, rain, age; /* of this column; `rain` is a share */
} np_cloud_column;

/* The column that runs through a position of the field. */
np_cloud_column np_cloud_column_compute(const np_cloud_model *model, float x_m, float y_m, float height_m);

/* Share of the column's thickness that it reaches. */
float np_cloud_column_compute_top(const np_cloud_model *model, const np_cloud_column *column);

/* The columns that a box may hold, freed from the skew. */
typedef struct np_cloud_columns {
  const np_cloud_box *box;
  float min_m[2], max_m[2];
} np_cloud_columns;

/* The columns that a box may hold between two of its heights. */
np_cloud_columns np_cloud_columns_make(const np_cloud_model *model, const np_cloud_box *box, float low_m, float high_m);

/* No strength and no anvil of the columns is above these. */
float np_cloud_columns_bound_strength(const np_cloud_model *model, const np_cloud_columns *columns);
float np_cloud_columns_bound_anvil(const np_cloud_model *model, const np_cloud_columns *columns);

/* Values of a picture's quantity; `fallback` where the picture has none. */
np_interval np_cloud_columns_bound_plane(const np_cloud_model *model, const np_cloud_columns *columns,
                                         neph_cloud_map_quantity quantity, float fallback);

/* Heights above the columns' bases over their thicknesses, held to [0, 1]. False: no height of the box is inside. */
bool np_cloud_columns_bound_shares(const np_cloud_model *model, const np_cloud_columns *columns, float low_m,
                                   float high_m, np_interval *out_shares);

#endif
