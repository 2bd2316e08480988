/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/measured_columns.h"

#include <math.h>

#include "cloud/cloud_model.h"
#include "core/alloc.h"
#include "core/math.h"

/* Cell of the lattice at a position, and the offsets of its neighbours. */
typedef struct lattice_cell {
  size_t index, right, up;
  float u, v;
} lattice_cell;

static lattice_cell locate(const np_measured_columns *columns, float x_m, float y_m) {
  const float at_m[2] = {x_m, y_m};
  float fraction[2];
  int32_t low[2];
  for (int a = 0; a < 2; a++) {
    const float last = (float)(columns->size[a] - 1);
    const float scaled = np_clampf((at_m[a] - columns->origin_m[a]) / columns->step_m, 0.0f, last);
    low[a] = (int32_t)scaled;
    fraction[a] = scaled - (float)low[a];
  }
  return (lattice_cell){.index = (size_t)low[1] * (size_t)columns->size[0] + (size_t)low[0],
                        .right = low[0] + 1 < columns->size[0] ? 1 : 0,
                        .up = low[1] + 1 < columns->size[1] ? (size_t)columns->size[0] : 0,
                        .u = fraction[0],
                        .v = fraction[1]};
}

static float interpolate(const float *values, const lattice_cell *cell, float fallback) {
  if (!values) return fallback;
  const float *at = values + cell->index;
  return np_mixf(np_mixf(at[0], at[cell->right], cell->u), np_mixf(at[cell->up], at[cell->up + cell->right], cell->u),
                 cell->v);
}

np_measured_column np_measured_columns_sample(const np_measured_columns *columns, float x_m, float y_m) {
  const lattice_cell cell = locate(columns, x_m, y_m);
  return (np_measured_column){.factor = interpolate(columns->factors, &cell, 1.0f),
                              .fill_per_m = interpolate(columns->fills_per_m, &cell, 0.0f),
                              .stretch = interpolate(columns->stretches, &cell, 1.0f)};
}

/* Integral of the profile from 0. */
static float integrate_fill(float share) {
  const float s = np_clampf(share, 0.0f, 1.0f);
  return s * s * (3.0f - 2.0f * s);
}

/* The first voxel whose middle is above the base has all that is below its upper face. */
float np_measured_columns_eval_fill(const np_measured_columns *columns, float stretch, float height_m) {
  const float share = height_m / columns->fill_top_m, voxel = columns->step_m * stretch / columns->fill_top_m;
  if (!(share > 0.0f)) return 0.0f;
  const float below = share > voxel ? integrate_fill(share - 0.5f * voxel) : 0.0f;
  return (integrate_fill(share + 0.5f * voxel) - below) / voxel;
}

bool np_measured_columns_has_fill(const np_measured_columns *columns, const np_cloud_box *box) {
  if (!columns->fills_per_m || box->max_m[2] <= 0.0f) return false;
  const lattice_cell low = locate(columns, box->min_m[0], box->min_m[1]);
  const lattice_cell high = locate(columns, box->max_m[0], box->max_m[1]);
  const size_t width = (size_t)columns->size[0], last = high.index + high.right;
  for (size_t row = low.index / width; row <= (high.index + high.up) / width; row++)
    for (size_t i = low.index % width; i <= last % width; i++)
      if (columns->fills_per_m[row * width + i] > 0.0f) return true;
  return false;
}

void np_measured_columns_clear(neph_context *context, np_measured_columns *columns) {
  np_alloc_free(context, columns->factors);
  np_alloc_free(context, columns->fills_per_m);
  np_alloc_free(context, columns->stretches);
  *columns = (np_measured_columns){.step_m = 0};
}

double np_measured_columns_count_bytes(const np_measured_columns *columns) {
  const int planes = (columns->factors != NULL) + (columns->fills_per_m != NULL) + (columns->stretches != NULL);
  return (double)planes * columns->size[0] * columns->size[1] * sizeof(float);
}
