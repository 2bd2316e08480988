/* SPDX-License-Identifier: Apache-2.0 */
/* Losses of a cloud through coarse voxels, measured before it is baked.
 *
 * In a field of few voxels all columns of voxels are compared with the mean of random columns within their footprints:
 * the voxels may miss clouds or exaggerate them. The waterline was chosen for the cover of these voxel columns, and
 * another voxel size will have its own. So the comparison is of mean optical depths of covered columns, with the finer
 * model's own waterline if that of the voxels shows a loss. In a field of more voxels, evenly spread columns are
 * compared with the finer model at the same positions. Grains of thermals are as fine as in models of smaller voxels,
 * so that there is nothing to compare.
 *
 * The evaluation is pointwise, without a grid: the same code measures the losses of any other voxel size. The warning
 * recommends the first size, repeatedly halved and rounded down to three digits, that would not warn. Sums are in the
 * order of columns, independent of threads. Losses must also be statistically significant: columns are a sample, whose
 * error is that of a ratio of sums over blocks or over halves of the draws (Cochran 1977, "Sampling Techniques", 6.4).
 */
#include "cloud/bake_loss.h"

#include <math.h>

#include "cloud/cloud_build.h"
#include "cloud/cloud_density.h"
#include "cloud/cloud_desc.h"
#include "cloud/cloud_grain.h"
#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "cloud/level_samples.h"
#include "cloud/shape_desc.h"
#include "core/alloc.h"
#include "core/random.h"

enum {
  COLUMNS_ALL = 22, /* columns along an axis up to which all are compared */
  BLOCK_COLUMNS = 4,
  BLOCKS_MAX = 64,
  FINE_HALVINGS = 3
};

/* Effort of a comparison: columns along an axis of a large field, and random columns in a small one. */
typedef struct column_effort {
  size_t columns, draws;
  double chance;      /* number of standard errors that a loss must exceed */
  bool has_waterline; /* the finer model's own waterline is searched */
} column_effort;

static const column_effort first_effort = {16, 484, 0, false}, second_effort = {32, 2304, 3, true};
static const double tolerated_share = 0.15;
static const double finer = 0.5; /* relative to the grain */

/* Columns of the finer model: sum of their optical depths, and number of covered ones. */
typedef struct drawn {
  double depth, covered;
} drawn;

/* A column of voxels, and columns of the finer model at its position or within its footprint, in two halves. */
typedef struct column_pair {
  double depth, covered;
  drawn halves[2];
  double painted, misplaced; /* coverage in the picture; difference between the two positions */
} column_pair;

typedef struct column_job {
  neph_context *context;
  const np_cloud_model *model;
  np_cloud_model detailed; /* borrows everything from the model */
  double voxel_m;
  size_t voxels[2], columns[2], draws; /* voxels along the field, columns of voxels, finer columns for each */
  bool is_all, has_detail;             /* all voxels are compared; the finer model differs */
  column_pair *pairs;
} column_job;

/* ---- Columns ---- */

static bool is_clear(const np_cloud_model *model, double x_m, double y_m) {
  const float x = (float)x_m, y = (float)y_m;
  const np_cloud_box box = {{x, y, 0.0f}, {x, y, (float)model->desc.thickness_m}};
  return np_cloud_model_is_empty(model, &box);
}

/* Optical depth over the thickness; `lowest` is the height of the lowest sample above the base in grains. */
static double measure_column(const np_cloud_model *model, double lowest, double x_m, double y_m) {
  const double step_m = model->desc.voxel_m;
  const size_t total = is_clear(model, x_m, y_m) ? 0 : (size_t)ceil(model->desc.thickness_m / step_m);
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK], extinction_per_m[NP_CLOUD_BLOCK];
  double depth = 0;
  for (size_t first = 0; first < total; first += NP_CLOUD_BLOCK) {
    np_cloud_points points = {total - first, x, y, height_m};
    if (points.count > NP_CLOUD_BLOCK) points.count = NP_CLOUD_BLOCK;
    for (size_t i = 0; i < points.count; i++) {
      x[i] = (float)x_m;
      y[i] = (float)y_m;
      height_m[i] = (float)(((double)(first + i) + lowest) * step_m);
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

static void compute_place(const column_job *job, size_t number, double out_place_m[2]) {
  const size_t at[2] = {number % job->columns[0], number / job->columns[0]};
  for (int a = 0; a < 2; a++) {
    const double voxel = floor(((double)at[a] + 0.5) * (double)job->voxels[a] / (double)job->columns[a]);
    out_place_m[a] = (voxel - 0.5 * (double)(job->voxels[a] - 1)) * job->voxel_m;
  }
}

static void add_drawn(const np_cloud_model *model, double lowest, const double place_m[2], drawn *sums) {
  const double depth = measure_column(model, lowest, place_m[0], place_m[1]);
  sums->depth += depth;
  sums->covered += depth > 0;
}

static void add_sampled(const np_cloud_model *model, const double place_m[2], drawn *sums) {
  add_drawn(model, np_level_samples_compute_lowest(model, place_m[0], place_m[1]), place_m, sums);
}

static void measure_pair(const column_job *job, size_t number, column_pair *out) {
  np_random random = np_random_start(job->model->desc.seed, 0, (uint32_t)number, 0, 0);
  drawn here = {0};
  double place_m[2];
  compute_place(job, number, place_m);
  if (job->is_all || job->has_detail) add_sampled(job->model, place_m, &here);
  *out = (column_pair){.depth = here.depth, .covered = here.covered};
  if (!job->is_all && job->has_detail) add_sampled(&job->detailed, place_m, &out->halves[0]);
  const double painted_here = sample_painted(job->model, place_m[0], place_m[1]);
  for (size_t i = 0; i < job->draws; i++) {
    double drawn_m[2];
    for (int a = 0; a < 2; a++) drawn_m[a] = place_m[a] + (np_random_double(&random) - 0.5) * job->voxel_m;
    if (job->is_all) add_drawn(&job->detailed, np_random_double(&random), drawn_m, &out->halves[i % 2]);
    const double painted = sample_painted(job->model, drawn_m[0], drawn_m[1]);
    out->painted += painted / (double)job->draws;
    out->misplaced += fabs(painted - painted_here) / (double)job->draws;
  }
}

static neph_result measure_pairs(void *user, size_t begin, size_t end, unsigned thread) {
  const column_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) measure_pair(job, i, &job->pairs[i]);
  return NEPH_OK;
}

/* ---- Losses ---- */

/* Relative loss; 0 if it is at most `least`. */
static double compute_loss(double kept, double whole, double least) {
  const double lost = whole > 0 ? 1 - kept / whole : 0;
  return lost > least ? lost : 0;
}

/* Sums over all pairs. */
typedef struct pair_sums {
  double depth, covered, painted, misplaced;
  drawn finer;
} pair_sums;

static pair_sums sum_pairs(const column_job *job, size_t count) {
  pair_sums sums = {0};
  for (size_t i = 0; i < count; i++) {
    const column_pair *p = &job->pairs[i];
    sums.depth += p->depth;
    sums.covered += p->covered;
    sums.painted += p->painted;
    sums.misplaced += p->misplaced;
    sums.finer.depth += p->halves[0].depth + p->halves[1].depth;
    sums.finer.covered += p->halves[0].covered + p->halves[1].covered;
  }
  return sums;
}

/* Relative variance of the mean depth of random columns: the halves of a footprint are independent. */
static double compute_drawn_variance(const column_job *job, size_t count, const pair_sums *sums, bool by_cover) {
  double variance = 0;
  for (size_t i = 0; i < count; i++) {
    const drawn *h = job->pairs[i].halves;
    const double covered = by_cover ? (h[0].covered - h[1].covered) / sums->finer.covered : 0;
    variance += pow((h[0].depth - h[1].depth) / sums->finer.depth - covered, 2);
  }
  return variance;
}

/* Relative variance of the ratio of depths at the same positions, over blocks of columns: columns of one cloud are
 * correlated. */
static double compute_block_variance(const column_job *job, size_t count, const pair_sums *sums) {
  const size_t across = (job->columns[0] + BLOCK_COLUMNS - 1) / BLOCK_COLUMNS;
  double residual[BLOCKS_MAX] = {0}, variance = 0;
  size_t blocks = 0;
  for (size_t i = 0; i < count; i++) {
    const column_pair *p = &job->pairs[i];
    const size_t block = i / job->columns[0] / BLOCK_COLUMNS * across + i % job->columns[0] / BLOCK_COLUMNS;
    residual[block] += p->depth / sums->depth - p->halves[0].depth / sums->finer.depth;
    if (block >= blocks) blocks = block + 1;
  }
  for (size_t b = 0; b < blocks; b++) variance += residual[b] * residual[b];
  return blocks > 1 ? variance * (double)blocks / (double)(blocks - 1) : (double)INFINITY;
}

/* Whether a picture sets the coverage; lines do not fill a picture. */
static bool is_painted(const np_cloud_model *model) { return model->map.levels && !model->kind->is_line; }

/* Whether finer voxels would have the same coverage by their own waterline. Kinds that thin out towards the border may
 * not reach it, and a given shape has no waterline. */
static bool is_of_coverage(const np_cloud_model *model) {
  return !model->kind->is_thin_at_border && !np_cloud_desc_has_shape(&model->desc);
}

/* Compares optical depths in voxels and in a finer bake with the same cover. */
static void compare_depths(const column_job *job, size_t count, const pair_sums *sums, double chance,
                           np_bake_losses *losses) {
  const double n = (double)count, draws = job->is_all ? n * (double)job->draws : n;
  const bool by_cover = job->is_all && is_of_coverage(job->model) && sums->covered > 0 && sums->finer.covered > 0;
  losses->depth = sums->depth / n;
  losses->finer_depth = sums->finer.depth / draws;
  if (by_cover) losses->finer_depth *= sums->covered / n / (sums->finer.covered / draws);
  if (!(sums->finer.depth > 0)) return;
  double variance = 0;
  if (job->is_all)
    variance = compute_drawn_variance(job, count, sums, by_cover);
  else if (sums->depth > 0)
    variance = compute_block_variance(job, count, sums);
  const double kept = losses->depth / losses->finer_depth;
  losses->of_depth = compute_loss(losses->depth, losses->finer_depth, chance > 0 ? chance * kept * sqrt(variance) : 0);
}

static np_bake_losses compare_pairs(const column_job *job, size_t count, double chance) {
  const np_cloud_model *model = job->model;
  const pair_sums sums = sum_pairs(job, count);
  const double n = (double)count;
  np_bake_losses losses = {.covered = sums.covered / n};
  losses.wanted = model->map.levels ? sums.painted / n : model->map.coverage;
  if (job->is_all || job->has_detail) compare_depths(job, count, &sums, chance, &losses);
  if (job->is_all && is_painted(model)) losses.of_coverage = compute_loss(losses.covered, losses.wanted, 0);
  losses.of_map = sums.painted > 0 ? 0.5 * sums.misplaced / sums.painted : 0;
  return losses;
}

static void choose_columns(column_job *job, const column_effort *effort) {
  const neph_cloud_desc *desc = &job->model->desc;
  for (int a = 0; a < 2; a++) job->voxels[a] = (size_t)fmax(round(desc->extent_m[a] / job->voxel_m), 1);
  job->is_all = job->voxels[0] <= COLUMNS_ALL && job->voxels[1] <= COLUMNS_ALL;
  for (int a = 0; a < 2; a++)
    job->columns[a] = job->is_all || job->voxels[a] < effort->columns ? job->voxels[a] : effort->columns;
  const size_t count = job->columns[0] * job->columns[1];
  job->draws = 2 * ((effort->draws + 2 * count - 1) / (2 * count));
}

/* Grain of the finer model, relative to the model's. For fields of thermals it is the grain of any smaller voxel. A
 * hero is one cloud, which changes with its grain. */
static double choose_share(const np_cloud_model *model) {
  const bool is_field = model->kind->has_thermals && !model->kind->is_single;
  return is_field ? fmin(np_cloud_compute_grain_m(&model->desc) / model->desc.voxel_m, 1) : finer;
}

/* Whether finer voxels have another waterline, which can be searched with the map of time 0 and without balls. */
static bool has_finer_waterline(const np_cloud_model *model) {
  return is_of_coverage(model) && !model->kind->has_thermals && !model->map.levels && model->desc.time_s == 0;
}

static neph_result measure_columns(neph_context *context, const np_cloud_model *model, const column_effort *effort,
                                   np_monitor *monitor, np_bake_losses *out_losses) {
  column_job job = {.context = context, .model = model, .voxel_m = model->desc.voxel_m * model->sample_count};
  const double share = choose_share(model);
  *out_losses = (np_bake_losses){0};
  if (model->is_empty) return NEPH_OK;
  choose_columns(&job, effort);
  job.has_detail = share < 1;
  job.detailed = np_cloud_model_refine(model, share);
  neph_result result = NEPH_OK;
  if (job.has_detail && effort->has_waterline && has_finer_waterline(model))
    result = model->kind->search_waterline(&job.detailed, monitor);
  if (result) return result;
  const size_t count = job.columns[0] * job.columns[1];
  job.pairs = np_alloc(context, count, sizeof *job.pairs);
  if (!job.pairs) return NEPH_ERROR_OUT_OF_MEMORY;
  result = np_parallel_for(context, monitor, count, 8, measure_pairs, &job);
  if (!result) *out_losses = compare_pairs(&job, count, effort->chance);
  np_alloc_free(context, job.pairs);
  return result;
}

neph_result np_bake_measure_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor,
                                   np_bake_losses *out_losses) {
  const neph_result result = measure_columns(context, model, &first_effort, monitor, out_losses);
  if (result || !np_bake_loses(out_losses)) return result;
  return measure_columns(context, model, &second_effort, monitor, out_losses);
}

bool np_bake_loses(const np_bake_losses *losses) {
  return losses->of_depth > tolerated_share || losses->of_coverage > tolerated_share ||
         losses->of_map > tolerated_share;
}

/* ---- Recommended voxel size ---- */

static double round_down(double value) {
  const double digit = pow(10, floor(log10(value)) - 2);
  return floor(value / digit * (1 + 1e-12)) * digit;
}

static neph_result probe_voxel(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m,
                               np_monitor *monitor, bool *out_loses) {
  np_cloud_model model;
  np_bake_losses losses;
  neph_result result = np_cloud_model_build(context, cloud, planet_radius_m, monitor, &model);
  if (result) return result;
  result = np_bake_measure_losses(context, &model, monitor, &losses);
  *out_loses = np_bake_loses(&losses);
  np_cloud_model_clear(&model);
  return result;
}

/* Halves the voxel until there is no loss, down to a quarter of the grain. 0: none found. */
static neph_result search_voxel(const np_cloud_model *model, np_monitor *monitor, double *out_voxel_m) {
  neph_cloud_desc probed = np_cloud_model_get_desc(model);
  bool loses = true;
  neph_result result = NEPH_OK;
  for (int fine = 0; fine < FINE_HALVINGS && loses && !result;) {
    fine += np_cloud_grain_count(&probed) == 1;
    probed.voxel_m = round_down(0.5 * probed.voxel_m);
    result = probe_voxel(model->context, &probed, model->planet_radius_m, monitor, &loses);
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

/* Thermals appear and vanish as a whole: one cell more or less is chance. */
static double get_coverage_tolerance(const np_cloud_model *model) {
  static const double tolerated = 0.03;
  const neph_cloud_desc *d = &model->desc;
  const double cell = d->cell_m * d->cell_m / (d->extent_m[0] * d->extent_m[1]);
  return model->kind->has_thermals ? fmax(tolerated, cell) : tolerated;
}

static void warn_of_coverage(neph_context *context, const np_cloud_model *model) {
  const double wanted = model->map.coverage, covered = model->covered;
  if (model->is_empty || model->map.levels || np_cloud_desc_has_shape(&model->desc)) return;
  if (fabs(covered - wanted) <= get_coverage_tolerance(model)) return;
  np_log(context, NEPH_LOG_WARNING, "%s: clouds cover %.2f of the field where coverage asks for %.2f: %s",
         np_cloud_desc_name(&model->desc), covered, wanted,
         covered < wanted ? model->kind->more_cover : model->kind->less_cover);
}

neph_result np_bake_warn_of_losses(neph_context *context, const np_cloud_model *model, np_monitor *monitor) {
  np_bake_losses losses;
  double voxel_m;
  if (model->desc.measurement) return NEPH_OK; /* columns have the measured optical depth in voxels of any size */
  warn_of_coverage(context, model);
  neph_result result = np_bake_measure_losses(context, model, monitor, &losses);
  if (result || !np_bake_loses(&losses)) return result;
  const neph_cloud_desc cloud = np_cloud_model_get_desc(model);
  result = search_voxel(model, monitor, &voxel_m);
  const loss_line rows[] = {
      {"mean optical depth", losses.of_depth, losses.depth, losses.finer_depth},
      {"painted coverage", losses.of_coverage, losses.covered, losses.wanted},
      {"painted map", losses.of_map, (1 - losses.of_map) * losses.wanted, losses.wanted},
  };
  for (size_t i = 0; i < sizeof rows / sizeof *rows && !result; i++)
    if (rows[i].share > tolerated_share) warn(context, &cloud, &rows[i], voxel_m);
  return result;
}

neph_result np_cloud_check_voxel(neph_context *context, const neph_cloud_desc *cloud, double planet_radius_m) {
  neph_cloud_desc checked;
  np_cloud_model model;
  np_monitor monitor;
  neph_result result = np_cloud_desc_read(context, cloud, &checked);
  if (result || checked.measurement) return result;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, context, NULL, NULL);
  result = np_cloud_model_build(context, &checked, planet_radius_m, &monitor, &model);
  if (!result) {
    result = np_bake_warn_of_losses(context, &model, &monitor);
    np_cloud_model_clear(&model);
  }
  np_float_mode_leave(mode);
  return result;
}
