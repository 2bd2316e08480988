/* SPDX-License-Identifier: Apache-2.0 */
/* Losses of a cloud to the size of its voxels, measured before it is baked.
 *
 * Columns of voxels, spread evenly over the field, are compared with columns of the model at half its grain, drawn
 * within the footprints of the same voxels: mean optical depth, coverage, and the painted coverage beneath them. Both
 * are evaluated pointwise, so that no grid is needed: the losses of any other voxel are measured by the same code, and
 * the voxel of the warning is the first, halved and rounded down to three digits, whose own bake would not warn. Sums
 * are in the order of columns, and do not depend on threads. Losses count when they are beyond chance as well: columns
 * are a sample, of a field of few voxels all there are.
 */
#include <math.h>

#include "cloud/bake_private.h"
#include "cloud/shape.h"
#include "core/alloc.h"
#include "core/random.h"

/* Columns along an axis: few first, so that a bake takes at most 5 % longer; more where these lose. */
enum { COLUMNS_FEW = 22, COLUMNS_MANY = 32, FINE_HALVINGS = 3 };

static const double tolerated_share = 0.15;
static const double chance = 3; /* standard errors */
static const double finer = 0.5;
static const double finer_step = 2; /* grains between the heights of a finer column, of which a mean alone is wanted */

/* A column of voxels, and the mean of columns within its footprint. */
typedef struct column_pair {
  double depth, finer_depth, finer_depth2;
  double painted, misplaced; /* coverage in the picture; difference between the two places */
  bool is_covered;
} column_pair;

typedef struct column_job {
  neph_context *context;
  const np_cloud_model *model;
  np_cloud_model detailed; /* lends all from the model */
  double voxel_m;
  size_t voxels[2], columns[2], draws; /* voxels along the field, columns of them, finer columns for each */
  column_pair *pairs;
} column_job;

/* ---- Columns ---- */

/* Heights that are looked at: one in each step, at this share of it. */
typedef struct column_heights {
  double step_m, share;
} column_heights;

static bool is_clear(const np_cloud_model *model, double x_m, double y_m) {
  const float x = (float)x_m, y = (float)y_m;
  const np_cloud_box box = {{x, y, 0.0f}, {x, y, (float)model->desc.thickness_m}};
  return np_cloud_model_is_empty(model, &box);
}

/* Optical depth over the thickness. */
static double measure_column(const np_cloud_model *model, const column_heights *heights, double x_m, double y_m) {
  const double step_m = heights->step_m;
  const size_t total = is_clear(model, x_m, y_m) ? 0 : (size_t)ceil(model->desc.thickness_m / step_m);
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK], extinction_per_m[NP_CLOUD_BLOCK];
  double depth = 0;
  for (size_t first = 0; first < total; first += NP_CLOUD_BLOCK) {
    np_cloud_points points = {total - first, x, y, height_m};
    if (points.count > NP_CLOUD_BLOCK) points.count = NP_CLOUD_BLOCK;
    for (size_t i = 0; i < points.count; i++) {
      x[i] = (float)x_m;
      y[i] = (float)y_m;
      height_m[i] = (float)(((double)(first + i) + heights->share) * step_m);
    }
    np_cloud_model_eval_points(model, &points, extinction_per_m);
    for (size_t i = 0; i < points.count; i++) depth += (double)extinction_per_m[i] * step_m;
  }
  return depth;
}

static double sample_painted(const np_cloud_model *model, double x_m, double y_m) {
  const float *shares = model->map.levels ? model->map.planes[NEPH_CLOUD_MAP_COVERAGE] : NULL;
  return shares ? (double)np_weather_map_sample(&model->map, shares, (float)x_m, (float)y_m) : 0.0;
}

static void measure_pair(const column_job *job, size_t number, column_pair *out) {
  const size_t at[2] = {number % job->columns[0], number / job->columns[0]};
  double place_m[2];
  for (int a = 0; a < 2; a++) {
    const double voxel = floor(((double)at[a] + 0.5) * (double)job->voxels[a] / (double)job->columns[a]);
    place_m[a] = (voxel - 0.5 * (double)(job->voxels[a] - 1)) * job->voxel_m;
  }
  np_random random = np_random_start(job->model->desc.seed, 0, (uint32_t)number, 0, 0);
  const double grain_m = job->model->desc.voxel_m;
  const column_heights grains = {grain_m, 0.5};
  *out = (column_pair){.depth = measure_column(job->model, &grains, place_m[0], place_m[1])};
  const double here = sample_painted(job->model, place_m[0], place_m[1]);
  out->is_covered = out->depth > 0;
  for (size_t i = 0; i < job->draws; i++) {
    const double x_m = place_m[0] + (np_random_double(&random) - 0.5) * job->voxel_m;
    const double y_m = place_m[1] + (np_random_double(&random) - 0.5) * job->voxel_m;
    const column_heights drawn = {finer_step * grain_m, np_random_double(&random)};
    const double depth = measure_column(&job->detailed, &drawn, x_m, y_m);
    const double painted = sample_painted(job->model, x_m, y_m);
    out->finer_depth += depth / (double)job->draws;
    out->finer_depth2 += depth * depth / (double)job->draws;
    out->painted += painted / (double)job->draws;
    out->misplaced += fabs(painted - here) / (double)job->draws;
  }
}

static neph_result measure_pairs(void *user, size_t begin, size_t end, unsigned thread) {
  const column_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) measure_pair(job, i, &job->pairs[i]);
  return NEPH_OK;
}

/* ---- Losses ---- */

static bool is_all(const column_job *job) {
  return job->columns[0] == job->voxels[0] && job->columns[1] == job->voxels[1];
}

/* Share that is lost, 0 when it may be chance. */
static double judge(double kept, double whole, double deviation) {
  const double lost = whole - kept;
  return whole > 0 && lost > chance * deviation ? lost / whole : 0;
}

/* Standard error of the difference of mean depths: of all voxels, that of the finer columns alone. */
static double compute_deviation(const column_job *job, size_t count) {
  double sum = 0, sum2 = 0;
  for (size_t i = 0; i < count; i++) {
    const column_pair *p = &job->pairs[i];
    sum += is_all(job) ? p->finer_depth : p->finer_depth - p->depth;
    sum2 += is_all(job) ? p->finer_depth2 : (p->finer_depth - p->depth) * (p->finer_depth - p->depth);
  }
  const double n = (double)count, draws = n * (is_all(job) ? (double)job->draws : 1.0);
  return sqrt(fmax(sum2 / n - (sum / n) * (sum / n), 0) / draws);
}

static np_bake_losses sum_pairs(const column_job *job, size_t count) {
  np_bake_losses losses = {0};
  double finer_depth = 0, misplaced = 0, painted = 0;
  for (size_t i = 0; i < count; i++) {
    losses.depth += job->pairs[i].depth / (double)count;
    losses.covered += (double)job->pairs[i].is_covered / (double)count;
    finer_depth += job->pairs[i].finer_depth / (double)count;
    misplaced += job->pairs[i].misplaced / (double)count;
    painted += job->pairs[i].painted / (double)count;
  }
  const np_cloud_model *model = job->model;
  losses.wanted = model->map.levels ? painted : model->map.coverage;
  const double by_chance = is_all(job) ? 0 : sqrt(losses.wanted * (1 - losses.wanted) / (double)count);
  losses.of_depth = judge(losses.depth, finer_depth, compute_deviation(job, count));
  losses.of_coverage = judge(losses.covered, losses.wanted, by_chance);
  losses.of_map = painted > 0 ? 0.5 * misplaced / painted : 0;
  losses.finer_depth = finer_depth;
  return losses;
}

/* A given shape has none to keep, and lines do not fill a picture. */
static bool has_coverage(const np_cloud_model *model) {
  const bool is_lines = model->desc.model == NEPH_CLOUD_MODEL_TRAILS && model->map.levels;
  return !np_cloud_desc_has_shape(&model->desc) && !is_lines;
}

static void choose_columns(column_job *job, size_t most) {
  const neph_cloud_desc *desc = &job->model->desc;
  for (int a = 0; a < 2; a++) {
    job->voxels[a] = (size_t)fmax(round(desc->extent_m[a] / job->voxel_m), 1);
    job->columns[a] = job->voxels[a] < most ? job->voxels[a] : most;
  }
  job->draws = (most * most + job->columns[0] * job->columns[1] - 1) / (job->columns[0] * job->columns[1]);
}

static neph_result measure_columns(neph_context *context, const np_cloud_model *model, size_t most,
                                   np_monitor *monitor, np_bake_losses *out_losses) {
  column_job job = {.context = context, .model = model, .voxel_m = model->desc.voxel_m * model->sample_count};
  *out_losses = (np_bake_losses){0};
  if (model->is_empty) return NEPH_OK;
  choose_columns(&job, most);
  job.detailed = np_cloud_model_refine(model, finer);
  const size_t count = job.columns[0] * job.columns[1];
  job.pairs = np_alloc(context, count, sizeof *job.pairs);
  if (!job.pairs) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_parallel_for(context, monitor, count, 8, measure_pairs, &job);
  if (!result) *out_losses = sum_pairs(&job, count);
  if (!has_coverage(model)) out_losses->of_coverage = 0;
  np_alloc_free(context, job.pairs);
  return result;
}

neph_result np_bake_measure_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor,
                                   np_bake_losses *out_losses) {
  const neph_result result = measure_columns(context, model, COLUMNS_FEW, monitor, out_losses);
  return result || !np_bake_loses(out_losses) ? result
                                              : measure_columns(context, model, COLUMNS_MANY, monitor, out_losses);
}

bool np_bake_loses(const np_bake_losses *losses) {
  return losses->of_depth > tolerated_share || losses->of_coverage > tolerated_share ||
         losses->of_map > tolerated_share;
}

/* ---- The voxel that keeps it ---- */

static double round_down(double value) {
  const double digit = pow(10, floor(log10(value)) - 2);
  return floor(value / digit * (1 + 1e-12)) * digit;
}

static neph_result probe_voxel(neph_context *context, const neph_cloud_desc *cloud, np_monitor *monitor,
                               bool *out_loses) {
  np_cloud_model model;
  np_bake_losses losses;
  neph_result result = np_cloud_model_build(context, cloud, monitor, &model);
  if (result) return result;
  result = np_bake_measure_losses(context, &model, monitor, &losses);
  *out_loses = np_bake_loses(&losses);
  np_cloud_model_clear(&model);
  return result;
}

/* Halved until nothing is lost, to a quarter of the grain at the finest. 0: none was found. */
static neph_result search_voxel(neph_context *context, const neph_cloud_desc *cloud, np_monitor *monitor,
                                double *out_voxel_m) {
  neph_cloud_desc probed = *cloud;
  bool loses = true;
  neph_result result = NEPH_OK;
  for (int fine = 0; fine < FINE_HALVINGS && loses && !result;) {
    fine += np_cloud_grain_count(&probed) == 1;
    probed.voxel_m = round_down(0.5 * probed.voxel_m);
    result = probe_voxel(context, &probed, monitor, &loses);
  }
  *out_voxel_m = loses ? 0 : probed.voxel_m;
  return result;
}

typedef struct loss_line {
  const char *name;
  double share, kept, whole;
} loss_line;

static void warn(neph_context *context, const neph_cloud_desc *cloud, const loss_line *row, double voxel_m) {
  const char *name = np_cloud_desc_name(cloud);
  if (voxel_m > 0)
    np_log(context, NEPH_LOG_WARNING,
           "%s: voxels of %.3g m lose %.0f %% of the %s, %.3g of %.3g is left: a voxel of %.10g m keeps it", name,
           cloud->voxel_m, 100 * row->share, row->name, row->kept, row->whole, voxel_m);
  else
    np_log(context, NEPH_LOG_INFO,
           "%s: %.0f %% less %s than the model's, %.3g of %.3g, at voxels of %.3g m and at finer ones alike: enlarge "
           "extent or billow",
           name, 100 * row->share, row->name, row->kept, row->whole, cloud->voxel_m);
}

neph_result np_bake_warn_of_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor) {
  np_bake_losses losses;
  double voxel_m;
  neph_result result = np_bake_measure_losses(context, model, monitor, &losses);
  if (result || !np_bake_loses(&losses)) return result;
  const neph_cloud_desc cloud = np_cloud_model_get_desc(model);
  result = search_voxel(context, &cloud, monitor, &voxel_m);
  const loss_line rows[] = {
      {"mean optical depth", losses.of_depth, losses.depth, losses.finer_depth},
      {"coverage", losses.of_coverage, losses.covered, losses.wanted},
      {"painted map", losses.of_map, (1 - losses.of_map) * losses.wanted, losses.wanted},
  };
  for (size_t i = 0; i < sizeof rows / sizeof *rows && !result; i++)
    if (rows[i].share > tolerated_share) warn(context, &cloud, &rows[i], voxel_m);
  return result;
}

neph_result np_cloud_check_voxel(neph_context *context, const neph_cloud_desc *cloud) {
  neph_cloud_desc checked;
  np_cloud_model model;
  np_monitor monitor;
  neph_result result = np_cloud_desc_read(context, cloud, &checked);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, NULL, NULL);
  result = np_cloud_model_build(context, &checked, &monitor, &model);
  if (!result) {
    result = np_bake_warn_of_losses(context, &model, &monitor);
    np_cloud_model_clear(&model);
  }
  np_float_mode_leave(mode);
  return result;
}
