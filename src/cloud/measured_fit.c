/* SPDX-License-Identifier: Apache-2.0 */
/* The model is surveyed twice in the voxels of the bake.
 *
 * Tops: the mean top of the model's cloudy columns is compared with the measured top, and heights are stretched by the
 * ratio. Without a measured top it is that of an adiabatic cloud, whose optical depth grows as H^(5/3) (Brenguier et
 * al. 2000, "Radiative Properties of Boundary Layer Clouds"), and which has the model's own top at the depth that 95 %
 * of the cloudy pixels stay below. The power 3/5 of its inverse is taken as 5/8, which square roots give: bits of a
 * bake must not depend on a library's powers.
 *
 * Depths: with t the optical depth of a column and B the measured depth, bilinear between pixels, each column has the
 * weight t·B. Of each pixel only the covered share of columns remains, the largest ones, less the weight of the next.
 * Factors on weights are bilinear between pixels, and found in a few rounds; a last factor, constant in a pixel, makes
 * its mean exact. A pixel where the model has too few cloudy columns gets a part of its depth as a smooth fill: a few
 * columns with all of it would be spikes. */
#include "cloud/measured_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cloud/cloud_name.h"
#include "cloud/measured_survey.h"
#include "core/alloc.h"
#include "core/math.h"

enum { ROUNDS = 4, SPARSE_COLUMNS = 512 /* columns along a side from which tops are surveyed in every second one */ };

static const float adiabatic_share_min = 0.3f;
static const float stretch_low = 0.25f, stretch_high = 16.0f;
static const double fill_share = 0.5;    /* share of the wanted columns up to which a pixel is filled */
static const double fill_noticed = 0.01; /* share of the optical depth from which fills are reported */

typedef struct fit {
  np_cloud_model *model;
  const np_measured_map *map;
  const neph_cloud_raster *raster;
  np_monitor *monitor;
  size_t count, pixel_count; /* columns, pixels */
  int32_t *pixels;           /* pixel of each column; negative: none */
  float (*places)[2];        /* its position among pixels */
  float *values;             /* tops, then depths, of columns */
  float *weights;            /* weights of columns */
  float *scales, *sums;      /* values of pixels */
  float *textures;           /* share of a pixel's depth in the model's columns; the rest is filled */
  float *members;            /* weights of a pixel's columns */
  size_t *order, *ends;      /* columns by pixel, and the end of each pixel's */
  float mean_top_m;          /* mean top of the model's cloudy columns */
  double depth, filled;      /* sums of optical depths of pixels */
} fit;

/* ---- Columns ---- */

static double get_drift_m(const np_cloud_model *model, int axis) { return (double)model->drift_m[axis]; }

static void get_offset_m(const fit *f, size_t i, double out[2]) {
  const np_measured_columns *columns = &f->model->columns;
  const size_t width = (size_t)columns->size[0];
  out[0] = (double)columns->origin_m[0] + (double)(i % width) * (double)columns->step_m;
  out[1] = (double)columns->origin_m[1] + (double)(i / width) * (double)columns->step_m;
}

/* Locates columns in the pixels of the map. The wind moves the field: positions in it are at time 0. */
static neph_result locate_columns(void *user, size_t begin, size_t end, unsigned thread) {
  const fit *f = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) {
    double at_m[2], pixel[2];
    get_offset_m(f, i, at_m);
    const bool is_inside = np_measured_map_locate(f->map, f->raster, at_m[0] - get_drift_m(f->model, 0),
                                                  at_m[1] - get_drift_m(f->model, 1), pixel);
    f->pixels[i] = is_inside ? (int32_t)np_measured_map_get_pixel(f->raster, pixel) : -1;
    for (int a = 0; a < 2; a++) f->places[i][a] = is_inside ? (float)pixel[a] : 0.0f;
  }
  return NEPH_OK;
}

/* Pixel of a column if it is cloudy; negative otherwise. */
static int32_t get_cloudy(const fit *f, size_t column) {
  const int32_t pixel = f->pixels[column];
  return pixel >= 0 && f->map->depths[pixel] > 0 ? pixel : -1;
}

/* Value of pixels, bilinear, at a column. */
static float sample(const fit *f, const float *values, size_t column, float lowest) {
  const double pixel[2] = {(double)f->places[column][0], (double)f->places[column][1]};
  return np_measured_map_sample(f->raster, values, pixel, lowest);
}

/* Lists columns by pixel. */
static void sort_columns(fit *f) {
  memset(f->ends, 0, (f->pixel_count + 1) * sizeof *f->ends);
  for (size_t i = 0; i < f->count; i++)
    if (f->pixels[i] >= 0) f->ends[f->pixels[i] + 1]++;
  for (size_t p = 0; p < f->pixel_count; p++) f->ends[p + 1] += f->ends[p];
  for (size_t i = 0; i < f->count; i++)
    if (f->pixels[i] >= 0) f->order[f->ends[f->pixels[i]]++] = i;
}

static size_t get_begin(const fit *f, size_t pixel) { return pixel ? f->ends[pixel - 1] : 0; }

/* ---- Tops ---- */

/* Mean tops of the model in each pixel, and of all cloudy columns; `sums` receives them, NaN where there is none. */
static double average_tops(fit *f) {
  double sum = 0, count = 0;
  for (size_t p = 0; p < f->pixel_count; p++) {
    double own = 0, columns = 0;
    for (size_t n = get_begin(f, p); n < f->ends[p]; n++) {
      const float top_m = f->values[f->order[n]];
      own += top_m > 0 ? (double)top_m : 0;
      columns += top_m > 0;
    }
    f->sums[p] = columns > 0 ? (float)(own / columns) : NAN;
    sum += f->map->depths[p] > 0 ? own : 0;
    count += f->map->depths[p] > 0 ? columns : 0;
  }
  return count > 0 ? sum / count : f->model->desc.thickness_m;
}

/* Measured top above the base; NaN: none. */
static float measure_top_m(const fit *f, size_t column) {
  const neph_cloud_raster *raster = &f->map->fields.top_m;
  double at_m[2], pixel[2];
  if (!raster->values) return NAN;
  get_offset_m(f, column, at_m);
  for (int a = 0; a < 2; a++) at_m[a] -= get_drift_m(f->model, a);
  if (!np_measured_map_locate(f->map, raster, at_m[0], at_m[1], pixel)) return NAN;
  return np_measured_map_sample(raster, raster->values, pixel, -1e5f) - (float)f->model->desc.base_altitude_m;
}

/* Top of the model near a column: the mean of its pixels, or of all where these are clear. */
static float get_model_top_m(const fit *f, size_t column) {
  const float near_m = sample(f, f->sums, column, 0);
  return isnan(near_m) ? f->mean_top_m : near_m;
}

typedef struct top_tally {
  size_t low, high, unknown, cloudy;
  float highest_m;
} top_tally;

/* Top that a column shall have, within the field's box. */
static float choose_top_m(const fit *f, size_t column, float own_m, top_tally *tally) {
  const float low_m = 2.0f * f->model->columns.step_m, high_m = (float)f->model->desc.thickness_m;
  const float measured_m = measure_top_m(f, column);
  tally->cloudy++;
  if (isnan(measured_m)) {
    const float depth = sample(f, f->map->depths, column, 0);
    tally->unknown++;
    const float share = depth / f->map->depth_high;
    return own_m * np_clampf(sqrtf(share * sqrtf(sqrtf(share))), adiabatic_share_min, 1.0f);
  }
  tally->low += measured_m < low_m;
  tally->high += measured_m > high_m;
  tally->highest_m = fmaxf(tally->highest_m, measured_m);
  return np_clampf(measured_m, low_m, high_m);
}

static void warn_of_tops(const fit *f, const top_tally *tally) {
  const neph_cloud_desc *desc = &f->model->desc;
  neph_context *context = f->model->context;
  const char *name = np_cloud_desc_name(desc);
  if (!f->map->fields.top_m.values) return;
  const double percent = 100.0 / (double)(tally->cloudy ? tally->cloudy : 1);
  if (tally->unknown > 0)
    np_log(context, NEPH_LOG_WARNING,
           "%s: %.3g %% of the cloudy columns have no measured top; an adiabatic cloud's is "
           "taken",
           name, percent * (double)tally->unknown);
  if (tally->high > 0)
    np_log(context, NEPH_LOG_WARNING,
           "%s: %.3g %% of the cloudy columns have a measured top above the field's, %.0f m, "
           "the highest %.0f m, and are cut there: raise thickness or base",
           name, percent * (double)tally->high, desc->base_altitude_m + desc->thickness_m,
           desc->base_altitude_m + (double)tally->highest_m);
  if (tally->low > 0)
    np_log(context, NEPH_LOG_WARNING,
           "%s: %.3g %% of the cloudy columns have a measured top less than two voxels above "
           "the base, %.0f m, and are two voxels thick: lower base",
           name, percent * (double)tally->low, desc->base_altitude_m);
}

static neph_result fit_tops(fit *f) {
  np_measured_columns *columns = &f->model->columns;
  const int32_t side = columns->size[0] > columns->size[1] ? columns->size[0] : columns->size[1];
  np_measured_survey survey = {.step = side > SPARSE_COLUMNS ? 2 : 1, .tops_m = f->values};
  neph_result result = np_measured_survey_make(f->model, f->monitor, &survey);
  float *stretches = result ? NULL : np_alloc(f->model->context, f->count, sizeof *stretches);
  if (!stretches) return result ? result : NEPH_ERROR_OUT_OF_MEMORY;
  f->mean_top_m = columns->fill_top_m = (float)average_tops(f);
  top_tally tally = {.highest_m = -INFINITY};
  columns->stretches = stretches;
  for (size_t i = 0; i < f->count; i++) {
    stretches[i] = 1.0f;
    if (get_cloudy(f, i) < 0) continue;
    const float own_m = get_model_top_m(f, i);
    stretches[i] = np_clampf(own_m / choose_top_m(f, i, own_m, &tally), stretch_low, stretch_high);
    columns->stretch_min = fminf(columns->stretch_min, stretches[i]);
    columns->stretch_max = fmaxf(columns->stretch_max, stretches[i]);
  }
  warn_of_tops(f, &tally);
  return NEPH_OK;
}

/* ---- Depths ---- */

static int compare_falling(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x < y) - (x > y);
}

/* Leaves only the covered share of a pixel's columns. */
static void cut_columns(fit *f, size_t begin, size_t count, size_t wanted) {
  qsort(f->members, count, sizeof *f->members, compare_falling);
  const float less = f->members[wanted];
  if (!(f->members[0] > less)) return; /* all alike */
  for (size_t n = 0; n < count; n++) {
    float *weight = &f->weights[f->order[begin + n]];
    *weight = fmaxf(*weight - less, 0.0f);
  }
}

/* Chooses the columns of a pixel. Returns how many more it needs: columns that are too few for their pixel would stand
 * out as spikes. */
static size_t choose_columns(fit *f, size_t pixel, size_t *out_cloudy) {
  const size_t begin = get_begin(f, pixel), count = f->ends[pixel] - begin;
  const double wanted = fmax(1.0, round((double)f->map->shares[pixel] * (double)count));
  size_t cloudy = 0;
  for (size_t n = 0; n < count; n++) {
    f->members[n] = f->weights[f->order[begin + n]];
    cloudy += f->members[n] > 0;
  }
  if ((double)cloudy > wanted) cut_columns(f, begin, count, (size_t)wanted);
  *out_cloudy = cloudy;
  const double needed = ceil(fill_share * wanted);
  return (double)cloudy < needed ? (size_t)needed - cloudy : 0;
}

/* Fills columns of a pixel that the model leaves clear, those with the largest measured depths, in proportion to these:
 * with `share` of the pixel's optical depth. */
static void fill_pixel(fit *f, size_t pixel, size_t missing, double share) {
  const np_measured_columns *columns = &f->model->columns;
  const float top_m = columns->fill_top_m;
  const size_t begin = get_begin(f, pixel), end = f->ends[pixel];
  size_t clear = 0;
  double sum = 0;
  for (size_t n = begin; n < end; n++)
    if (!(f->weights[f->order[n]] > 0)) f->members[clear++] = sample(f, f->map->depths, f->order[n], 0);
  qsort(f->members, clear, sizeof *f->members, compare_falling);
  const float lowest = f->members[missing - 1];
  for (size_t n = 0; n < clear && f->members[n] >= lowest; n++) sum += (double)f->members[n];
  const float scale = (float)(share * (double)f->map->depths[pixel] * (double)(end - begin) / sum);
  for (size_t n = begin; n < end; n++) {
    const size_t i = f->order[n];
    const float depth = sample(f, f->map->depths, i, 0);
    if (f->weights[i] > 0 || depth < lowest) continue;
    columns->stretches[i] *= top_m / get_model_top_m(f, i); /* the fill ends at the column's top */
    columns->fills_per_m[i] = scale * depth * columns->stretches[i] / top_m;
  }
}

/* Sets the weights of columns, and fills pixels where the model has too few. */
static void weigh_columns(fit *f) {
  for (size_t i = 0; i < f->count; i++)
    f->weights[i] = get_cloudy(f, i) < 0 ? 0.0f : f->values[i] * sample(f, f->map->depths, i, 0);
  for (size_t p = 0; p < f->pixel_count; p++) {
    const double depth = (double)f->map->depths[p];
    if (!(depth > 0) || f->ends[p] == get_begin(f, p)) continue;
    size_t cloudy;
    const size_t missing = choose_columns(f, p, &cloudy);
    const double share = (double)missing / (double)(missing + cloudy);
    f->textures[p] = (float)(1.0 - share);
    f->depth += depth;
    f->filled += share * depth;
    if (missing > 0) fill_pixel(f, p, missing, share);
  }
}

/* Ratio of the measured depth to the mean of the weights, for each pixel. */
static void compute_ratios(fit *f) {
  for (size_t p = 0; p < f->pixel_count; p++) {
    double sum = 0;
    for (size_t n = get_begin(f, p); n < f->ends[p]; n++) sum += (double)f->weights[f->order[n]];
    const double count = (double)(f->ends[p] - get_begin(f, p));
    f->scales[p] = sum > 0 ? (float)((double)(f->textures[p] * f->map->depths[p]) * count / sum) : NAN;
  }
}

static void fit_factors(fit *f) {
  weigh_columns(f);
  for (int round = 0; round < ROUNDS; round++) {
    compute_ratios(f);
    for (size_t i = 0; i < f->count; i++)
      if (f->weights[i] > 0) f->weights[i] *= sample(f, f->scales, i, 0);
  }
  compute_ratios(f);
  for (size_t i = 0; i < f->count; i++)
    f->model->columns.factors[i] = f->weights[i] > 0 ? f->weights[i] * f->scales[f->pixels[i]] / f->values[i] : 0;
}

static neph_result fit_depths(fit *f) {
  np_measured_columns *columns = &f->model->columns;
  neph_context *context = f->model->context;
  memset(f->values, 0, f->count * sizeof *f->values);
  np_measured_survey survey = {.step = 1, .depths = f->values};
  neph_result result = np_measured_survey_make(f->model, f->monitor, &survey);
  if (result) return result;
  columns->factors = np_alloc(context, f->count, sizeof *columns->factors);
  columns->fills_per_m = np_alloc(context, f->count, sizeof *columns->fills_per_m);
  if (!columns->factors || !columns->fills_per_m) return NEPH_ERROR_OUT_OF_MEMORY;
  fit_factors(f);
  if (f->filled > fill_noticed * f->depth)
    np_log(context, NEPH_LOG_WARNING,
           "%s: %.3g %% of the measured optical depth is filled in smoothly, in pixels where the model has too few "
           "cloudy columns",
           np_cloud_desc_name(&f->model->desc), 100.0 * f->filled / f->depth);
  if (!(f->filled > 0)) {
    np_alloc_free(context, columns->fills_per_m);
    columns->fills_per_m = NULL;
  }
  return NEPH_OK;
}

/* ---- Fit ---- */

static neph_result allocate(fit *f) {
  neph_context *context = f->model->context;
  f->pixels = np_alloc(context, f->count, sizeof *f->pixels);
  f->places = np_alloc(context, f->count, sizeof *f->places);
  f->values = np_alloc(context, f->count, sizeof *f->values);
  f->weights = np_alloc(context, f->count, sizeof *f->weights);
  f->members = np_alloc(context, f->count, sizeof *f->members);
  f->order = np_alloc(context, f->count, sizeof *f->order);
  f->ends = np_alloc(context, f->pixel_count + 1, sizeof *f->ends);
  f->scales = np_alloc(context, f->pixel_count, sizeof *f->scales);
  f->sums = np_alloc(context, f->pixel_count, sizeof *f->sums);
  f->textures = np_alloc(context, f->pixel_count, sizeof *f->textures);
  const bool is_done = f->pixels && f->places && f->values && f->weights && f->members && f->order && f->ends &&
                       f->scales && f->sums && f->textures;
  return is_done ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void clear(fit *f) {
  void *const blocks[] = {f->pixels, f->places, f->values, f->weights, f->members,
                          f->order,  f->ends,   f->scales, f->sums,    f->textures};
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) np_alloc_free(f->model->context, blocks[i]);
}

/* Reports the part of the field that the measurement does not cover. */
static neph_result check_cover(const fit *f) {
  const char *name = np_cloud_desc_name(&f->model->desc);
  const size_t inside = f->ends[f->pixel_count - 1];
  if (inside == 0)
    return np_fail(f->model->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "%s: the measured map %s does not reach the field, %g × %g m around %g, %g m: move center or place",
                   name, f->map->source->name, f->model->desc.extent_m[0], f->model->desc.extent_m[1],
                   f->model->desc.center_m[0], f->model->desc.center_m[1]);
  if (inside < f->count)
    np_log(f->model->context, NEPH_LOG_WARNING,
           "%s: the measured map %s covers %.3g %% of the field; the rest is left clear", name, f->map->source->name,
           100.0 * (double)inside / (double)f->count);
  return NEPH_OK;
}

neph_result np_measured_fit(np_cloud_model *model, const np_measured_map *map, np_monitor *monitor) {
  const neph_cloud_raster *raster = &map->fields.optical_depth;
  fit f = {.model = model, .map = map, .raster = raster, .monitor = monitor};
  neph_result result = np_measured_lattice_make(model, &model->columns);
  if (result) return result;
  f.count = (size_t)model->columns.size[0] * (size_t)model->columns.size[1];
  f.pixel_count = (size_t)raster->width * raster->height;
  result = allocate(&f);
  if (!result) result = np_parallel_for(model->context, monitor, f.count, 4096, locate_columns, &f);
  if (!result) sort_columns(&f);
  if (!result) result = check_cover(&f);
  if (!result) result = fit_tops(&f);
  if (!result) result = fit_depths(&f);
  clear(&f);
  return result;
}
