/* SPDX-License-Identifier: Apache-2.0 */
/* The profile of a cloud, measured on its model at several types: mean extinction at each share of a column's height,
 * over the columns that hold cloud, relative to the extinction of the core. Columns count by their thickness, so that
 * profile times thickness is the mean optical depth. */
#include <string.h>

#include "cloud/cloud_density.h"
#include "core/alloc.h"
#include "core/parallel.h"
#include "export/texture_cloud.h"

enum { TYPES = 8, HEIGHTS = 64, COLUMNS = 48 };

/* Sums over the columns of one row of the field. */
typedef struct profile_row {
  double sums[HEIGHTS];
  double weight;
} profile_row;

typedef struct type_profile {
  const np_texture_cloud *cloud;
  np_bake bake;
  profile_row rows[COLUMNS];
  float values[TYPES][HEIGHTS];
} type_profile;

static void add_column(const np_cloud_model *model, float x_m, float y_m, profile_row *row) {
  const np_texture_column column = np_texture_column_measure(model, x_m, y_m);
  float x[HEIGHTS], y[HEIGHTS], height[HEIGHTS], extinction[HEIGHTS];
  if (!column.has_cloud) return;
  for (int i = 0; i < HEIGHTS; i++) {
    x[i] = x_m;
    y[i] = y_m;
    height[i] = column.base_m + (column.top_m - column.base_m) * ((float)i + 0.5f) / HEIGHTS;
  }
  const np_cloud_points points = {HEIGHTS, x, y, height};
  np_cloud_model_eval_points(model, &points, extinction);
  const double weight = (double)(column.top_m - column.base_m);
  for (int i = 0; i < HEIGHTS; i++) row->sums[i] += weight * (double)extinction[i];
  row->weight += weight;
}

static neph_result add_rows(void *user, size_t begin, size_t end, unsigned thread) {
  type_profile *p = user;
  const np_cloud_model *model = &p->bake.model;
  (void)thread;
  for (size_t y = begin; y < end; y++) {
    p->rows[y] = (profile_row){.weight = 0.0};
    for (int x = 0; x < COLUMNS && !model->is_empty; x++)
      add_column(model, (float)(((x + 0.5) / COLUMNS - 0.5) * model->desc.extent_m[0]),
                 (float)((((double)y + 0.5) / COLUMNS - 0.5) * model->desc.extent_m[1]), &p->rows[y]);
  }
  return NEPH_OK;
}

static neph_result measure_type(type_profile *p, int type) {
  const np_texture_set *set = p->cloud->set;
  neph_result result = np_texture_cloud_start_model(p->cloud, (double)type / (TYPES - 1), &p->bake);
  if (result) return result;
  result = np_parallel_for(set->context, set->monitor, COLUMNS, 1, add_rows, p);
  const double core_per_m = p->bake.model.desc.extinction_per_m;
  np_bake_end(&p->bake);
  for (int i = 0; i < HEIGHTS && !result; i++) {
    double sum = 0.0, weight = 0.0;
    for (int y = 0; y < COLUMNS; y++) {
      sum += p->rows[y].sums[i];
      weight += p->rows[y].weight;
    }
    p->values[type][i] = weight > 0.0 ? (float)(sum / (weight * core_per_m)) : 0.0f;
  }
  return result;
}

/* Other kinds have no types: all of theirs are alike. */
static bool has_types(const neph_cloud_desc *desc) {
  return desc->model == NEPH_CLOUD_MODEL_CELLS || np_cloud_kind_get(desc->model)->has_thermals;
}

static neph_result measure(type_profile *p) {
  const np_monitor_part part = np_monitor_get_part(p->cloud->set->monitor);
  neph_result result = NEPH_OK;
  for (int type = 0; type < TYPES && !result; type++) {
    np_monitor_set_part(p->cloud->set->monitor, part, (double)type / TYPES, (type + 1.0) / TYPES);
    if (type == 0 || has_types(&p->cloud->in_frame.desc))
      result = measure_type(p, type);
    else
      memcpy(p->values[type], p->values[0], sizeof p->values[0]);
  }
  return result;
}

static neph_result fill_table(void *user, unsigned slice, float *out_values) {
  const type_profile *p = user;
  (void)slice;
  for (int i = 0; i < HEIGHTS; i++)
    for (int type = 0; type < TYPES; type++) out_values[i * TYPES + type] = p->values[type][i];
  return NEPH_OK;
}

neph_result np_texture_profile_add(const np_texture_cloud *cloud) {
  neph_context *context = cloud->set->context;
  type_profile *p = np_alloc(context, 1, sizeof *p);
  neph_result result = NEPH_OK;
  if (!p) return NEPH_ERROR_OUT_OF_MEMORY;
  p->cloud = cloud;
  np_texture texture = {
      .purpose = "density over height by type",
      .mapping = "u: type, texel i of n at i/(n − 1); v: share of the column's height, (height above base)/thickness, "
                 "texel i of n at (i + 1/2)/n",
      .texel = NP_TEXEL_R16F,
      .dimensions = 2,
      .size = {TYPES, HEIGHTS, 1},
      .channels = {{"mean extinction over columns that hold cloud, by their thickness, relative to extinction_per_m",
                    "1", 1.0}},
      .fill = fill_table,
      .user = p};
  if (!cloud->set->desc->is_dry_run) result = measure(p);
  if (!result) result = np_texture_cloud_add_one(cloud, "profile", &texture);
  np_alloc_free(context, p);
  return result;
}
