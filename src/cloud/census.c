/* SPDX-License-Identifier: Apache-2.0 */
/* Measures cloud cover: the share of the field's columns that hold cloud. */
#include "cloud/census.h"

#include <math.h>

#include "cloud/cloud_density.h"
#include "cloud/cloud_kinds.h"
#include "cloud/level_samples.h"

enum { CENSUS_COLUMNS_MAX = 64, CENSUS_HEIGHTS = 24, CENSUS_HEIGHTS_MAX = 48 };
enum { CENSUS_WHITE = 1024 };

typedef struct census {
  const np_cloud_model *model;
  int columns[2], heights; /* columns along each axis; heights in each */
  float cell_m[2], step_m; /* distances between columns, and between heights */
  bool is_at_voxels;       /* heights are those of the voxels, which differ between columns */
  atomic_size_t covered, wanted;
} census;

/* Chooses the heights: those of the voxels if they matter or are few. */
static void set_heights(const np_cloud_model *model, census *c) {
  const neph_cloud_desc *desc = &model->desc;
  const double voxels = ceil(desc->thickness_m / desc->voxel_m);
  const double heights =
      fmax(CENSUS_HEIGHTS, ceil(model->kind->census_per_billow * desc->thickness_m / desc->billow_m));
  const bool matter = model->sample_count > 1 || model->kind->has_thin_rims;
  c->is_at_voxels = matter && voxels <= NP_CLOUD_BLOCK;
  c->heights = (int)fmin(voxels, matter ? NP_CLOUD_BLOCK : fmin(heights, CENSUS_HEIGHTS_MAX));
  c->step_m = (float)(c->is_at_voxels ? desc->voxel_m : desc->thickness_m / c->heights);
}

/* Plans the census. If voxels are coarser than the model, it uses the columns of the voxels (all of them if they are
 * few) and each grain: other columns would miss clouds by chance. */
static census make_census(const np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  census c = {.model = model};
  const int columns_max = model->is_sketch ? CENSUS_COLUMNS_MAX / 2 : CENSUS_COLUMNS_MAX;
  set_heights(model, &c);
  for (int a = 0; a < 2; a++) {
    const double voxel_m = desc->voxel_m * model->sample_count, voxels = fmax(round(desc->extent_m[a] / voxel_m), 1);
    const bool is_all = model->sample_count > 1 && voxels <= columns_max;
    c.columns[a] = is_all ? (int)voxels : columns_max;
    c.cell_m[a] = is_all ? (float)voxel_m : (float)desc->extent_m[a] / (float)columns_max;
  }
  return c;
}

/* Columns of a row, and points of those not yet known to be covered. */
typedef struct census_row {
  const census *census;
  bool is_covered[CENSUS_COLUMNS_MAX];
  size_t count;
  uint8_t column[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
} census_row;

static void eval_points(census_row *row) {
  float extinction[NP_CLOUD_BLOCK];
  const np_cloud_points points = {row->count, row->x_m, row->y_m, row->height_m};
  np_cloud_model_eval_points(row->census->model, &points, extinction);
  for (size_t n = 0; n < row->count; n++)
    if (extinction[n] > 0.0f) row->is_covered[row->column[n]] = true;
  row->count = 0;
}

static float compute_place_m(const census *c, int axis, size_t i) {
  return ((float)i + 0.5f - 0.5f * (float)c->columns[axis]) * c->cell_m[axis];
}

/* Adds the heights of a column from `first` on in steps. */
static void add_column(census_row *row, int column, float y_m, int first, int step) {
  const census *c = row->census;
  const float x_m = compute_place_m(c, 0, (size_t)column);
  const float lowest = c->is_at_voxels ? (float)np_level_samples_compute_lowest(c->model, x_m, y_m) : 0.5f;
  if (row->count + (size_t)c->heights > NP_CLOUD_BLOCK) eval_points(row);
  for (int i = first; i < c->heights; i += step) {
    const size_t n = row->count++;
    row->column[n] = (uint8_t)column;
    row->x_m[n] = x_m;
    row->y_m[n] = y_m;
    row->height_m[n] = ((float)i + lowest) * c->step_m;
  }
}

/* Requested coverage of a position, as an integer, so that sums do not depend on threads. */
static size_t get_share(const np_cloud_model *model, float x_m, float y_m) {
  if (!model->map.levels) return (size_t)(model->map.coverage * CENSUS_WHITE + 0.5);
  const float *shares = model->map.planes[NEPH_CLOUD_MAP_COVERAGE];
  return (size_t)(np_weather_map_sample(&model->map, shares, x_m, y_m) * (float)CENSUS_WHITE + 0.5f);
}

/* Counts the covered columns of one row. A few heights decide most columns; the others are evaluated only if those are
 * clear. */
static void count_covered(census *c, size_t y) {
  static const int first[] = {1, 3, 0, 2};
  const int passes = c->model->kind->census_passes;
  census_row row = {.census = c};
  size_t covered = 0, wanted = 0;
  for (int pass = 0; pass < passes; pass++) {
    for (int i = 0; i < c->columns[0]; i++)
      if (!row.is_covered[i]) add_column(&row, i, compute_place_m(c, 1, y), passes > 1 ? first[pass] : 0, passes);
    if (row.count) eval_points(&row);
  }
  for (int i = 0; i < c->columns[0]; i++) {
    const size_t share = get_share(c->model, compute_place_m(c, 0, (size_t)i), compute_place_m(c, 1, y));
    const size_t weight = c->model->map.levels ? share : 1;
    covered += row.is_covered[i] ? weight * CENSUS_WHITE : 0;
    wanted += weight * share;
  }
  atomic_fetch_add(&c->covered, covered);
  atomic_fetch_add(&c->wanted, wanted);
}

static neph_result count_rows(void *user, size_t begin, size_t end, unsigned thread) {
  census *c = user;
  (void)thread;
  for (size_t row = begin; row < end; row++) count_covered(c, row);
  return NEPH_OK;
}

/* Covered share of the field's sky. In a picture columns are weighted by their coverage, so that its grey borders do
 * not compensate clear sky inside. */
neph_result np_census_count(const np_cloud_model *model, np_monitor *monitor, double *out_fraction) {
  census c = make_census(model);
  atomic_init(&c.covered, 0);
  atomic_init(&c.wanted, 0);
  neph_result result = np_parallel_for(model->context, monitor, (size_t)c.columns[1], 1, count_rows, &c);
  const double covered = (double)atomic_load(&c.covered), wanted = (double)atomic_load(&c.wanted);
  *out_fraction = model->map.levels && wanted > 0 ? model->map.coverage * covered / wanted
                                                  : covered / ((double)CENSUS_WHITE * c.columns[0] * c.columns[1]);
  return result;
}
