/* SPDX-License-Identifier: Apache-2.0 */
/* Columns of a model that is fitted to a measured field. Each has a factor on extinction, a factor on heights, and a
 * smooth extinction where the model has no cloud. They stand where the columns of voxels do, bilinear between. */
#ifndef NP_CLOUD_MEASURED_COLUMNS_H
#define NP_CLOUD_MEASURED_COLUMNS_H

#include <stdbool.h>
#include <stdint.h>

#include <nephos/context.h>

#include "cloud/cloud_kinds.h"

typedef struct np_measured_columns {
  int32_t size[2];
  float origin_m[2], step_m;
  float *factors;     /* NULL: 1 */
  float *fills_per_m; /* mean extinction over the column's thickness; NULL: 0 */
  float *stretches;   /* height in the model relative to the actual height; NULL: there are no columns */
  float fill_top_m;   /* height in the model at which fills end */
  float stretch_min, stretch_max;
} np_measured_columns;

/* Interpolation at a position of the field. */
typedef struct np_measured_column {
  float factor, fill_per_m, stretch;
} np_measured_column;

np_measured_column np_measured_columns_sample(const np_measured_columns *columns, float x_m, float y_m);

/* Profile 6·s·(1 − s) of a fill, whose mean over [0, 1] is 1, at a height in the model, as the mean over a voxel of the
 * lattice: voxels of a column have the fill's optical depth, however few they are. */
float np_measured_columns_eval_fill(const np_measured_columns *columns, float stretch, float height_m);

/* Whether a box holds a column with a fill. */
bool np_measured_columns_has_fill(const np_measured_columns *columns, const np_cloud_box *box);

void np_measured_columns_clear(neph_context *context, np_measured_columns *columns); /* zeroed ones are allowed */
double np_measured_columns_count_bytes(const np_measured_columns *columns);

#endif
