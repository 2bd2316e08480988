/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/measured_survey.h"

#include <math.h>

#include "cloud/cloud_density.h"
#include "cloud/cloud_name.h"
#include "core/math.h"

enum { EDGE = 8 /* columns along a tile, and voxels of a column that are evaluated together */, SIDE_MAX = 16384 };

static const float noticeable = 0.05f; /* extinction of a top, relative to the core's */

typedef struct survey_job {
  const np_cloud_model *model;
  np_measured_survey *survey;
  float voxel_m;
  size_t tiles_across;
} survey_job;

static double get_voxel_m(const np_cloud_model *model) { return model->desc.voxel_m * model->sample_count; }

neph_result np_measured_lattice_make(const np_cloud_model *model, np_measured_columns *out_columns) {
  const neph_cloud_desc *desc = &model->desc;
  const double voxel_m = get_voxel_m(model);
  *out_columns = (np_measured_columns){.step_m = (float)voxel_m, .stretch_min = 1.0f, .stretch_max = 1.0f};
  for (int a = 0; a < 2; a++) {
    const double count = fmax(1.0, round(desc->extent_m[a] / voxel_m));
    if (count > SIDE_MAX)
      return np_fail(
          model->context, NEPH_ERROR_LIMIT,
          "%s.extent[%d] is %g m, must be at most %g m with voxels of %g m and a measured map: enlarge voxel",
          np_cloud_desc_name(desc), a, desc->extent_m[a], SIDE_MAX * voxel_m, voxel_m);
    out_columns->size[a] = (int32_t)count;
    out_columns->origin_m[a] = (float)(-0.5 * (count - 1) * voxel_m);
  }
  return NEPH_OK;
}

/* ---- Tiles ---- */

typedef struct tile {
  size_t index[EDGE * EDGE];
  float x_m[EDGE * EDGE], y_m[EDGE * EDGE];
  size_t count;
  np_cloud_box box;
  double drop_m; /* drop of the planet's surface in the middle */
} tile;

static tile make_tile(const survey_job *job, size_t number) {
  const np_measured_columns *columns = &job->model->columns;
  const int32_t step = job->survey->step;
  const int32_t first[2] = {(int32_t)(number % job->tiles_across) * EDGE * step,
                            (int32_t)(number / job->tiles_across) * EDGE * step};
  tile t = {.box = {{INFINITY, INFINITY, 0}, {-INFINITY, -INFINITY, 0}}};
  for (int32_t n = 0; n < EDGE * EDGE; n++) {
    const int32_t at[2] = {first[0] + n / EDGE * step, first[1] + n % EDGE * step};
    if (at[0] >= columns->size[0] || at[1] >= columns->size[1]) continue;
    const float place_m[2] = {columns->origin_m[0] + (float)at[0] * columns->step_m,
                              columns->origin_m[1] + (float)at[1] * columns->step_m};
    t.index[t.count] = (size_t)at[1] * (size_t)columns->size[0] + (size_t)at[0];
    t.x_m[t.count] = place_m[0];
    t.y_m[t.count++] = place_m[1];
    for (int a = 0; a < 2; a++) {
      t.box.min_m[a] = fminf(t.box.min_m[a], place_m[a]);
      t.box.max_m[a] = fmaxf(t.box.max_m[a], place_m[a]);
    }
  }
  const double x_m = job->model->desc.center_m[0] + (double)t.x_m[0];
  const double y_m = job->model->desc.center_m[1] + (double)t.y_m[0];
  t.drop_m = 0.5 * (x_m * x_m + y_m * y_m) / job->model->planet_radius_m;
  return t;
}

/* Height of an offset above the base, along the planet's curved surface. */
static float compute_height_m(const np_cloud_model *model, float x_m, float y_m, double z_m) {
  const neph_cloud_desc *desc = &model->desc;
  const np_dvec3 at = {desc->center_m[0] + (double)x_m, desc->center_m[1] + (double)y_m, desc->base_altitude_m + z_m};
  return (float)(np_altitude(at, model->planet_radius_m) - desc->base_altitude_m);
}

static void add_values(const survey_job *job, const tile *t, const float *heights_m, const float *values) {
  const np_measured_survey *survey = job->survey;
  const float lowest = noticeable * (float)job->model->desc.extinction_per_m;
  for (size_t n = 0; n < t->count * EDGE; n++) {
    const size_t column = t->index[n / EDGE];
    if (survey->depths) survey->depths[column] += values[n] * job->voxel_m;
    if (survey->tops_m && values[n] > lowest)
      survey->tops_m[column] = fmaxf(survey->tops_m[column], heights_m[n] + 0.5f * job->voxel_m);
  }
}

/* Evaluates voxels [first, first + EDGE) of the columns of a tile. */
static void add_layer(const survey_job *job, const tile *t, int32_t first) {
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK], values[NP_CLOUD_BLOCK];
  np_cloud_box box = t->box;
  box.min_m[2] = INFINITY, box.max_m[2] = -INFINITY;
  for (size_t n = 0; n < t->count * EDGE; n++) {
    x_m[n] = t->x_m[n / EDGE];
    y_m[n] = t->y_m[n / EDGE];
    height_m[n] = compute_height_m(job->model, x_m[n], y_m[n],
                                   ((double)(first + (int32_t)(n % EDGE)) + 0.5) * (double)job->voxel_m);
    box.min_m[2] = fminf(box.min_m[2], height_m[n]);
    box.max_m[2] = fmaxf(box.max_m[2], height_m[n]);
  }
  if (np_cloud_model_is_empty(job->model, &box)) return;
  const np_cloud_points points = {t->count * EDGE, x_m, y_m, height_m};
  np_cloud_model_eval(job->model, &points, values);
  add_values(job, t, height_m, values);
}

static neph_result survey_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  const survey_job *job = user;
  const double voxel_m = (double)job->voxel_m, rain_m = (double)job->model->rain.depth_m;
  (void)thread;
  for (size_t number = begin; number < end; number++) {
    const tile t = make_tile(job, number);
    const int32_t low = (int32_t)floor((-t.drop_m - rain_m) / voxel_m) - EDGE;
    const int32_t high = (int32_t)ceil((job->model->desc.thickness_m - t.drop_m) / voxel_m) + EDGE;
    for (int32_t k = low; k < high; k += EDGE) add_layer(job, &t, k);
  }
  return NEPH_OK;
}

neph_result np_measured_survey_make(const np_cloud_model *model, np_monitor *monitor, np_measured_survey *survey) {
  const size_t edge = (size_t)(EDGE * survey->step);
  survey_job job = {.model = model, .survey = survey, .voxel_m = (float)get_voxel_m(model)};
  job.tiles_across = ((size_t)model->columns.size[0] + edge - 1) / edge;
  const size_t count = job.tiles_across * (((size_t)model->columns.size[1] + edge - 1) / edge);
  return np_parallel_for(model->context, monitor, count, 1, survey_tiles, &job);
}
