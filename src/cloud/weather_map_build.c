/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the weather map: the landscape of cells in texels, combined with a picture.
 *
 * A picture's coverage c is the covered share of the sky in the neighbourhood. So the landscape is measured relative to
 * a level: its own quantile of 1 − c at each position. Everything above the level is cloud, and the census only adjusts
 * one waterline near 0. Levels follow the painted position at every height of a sheared column. Other channels become
 * planes of texels, whose extremes over a rectangle give bounds. */
#include "cloud/weather_map_build.h"

#include <math.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "cloud/cloud_name.h"
#include "cloud/ground_map.h"
#include "cloud/landscape.h"
#include "cloud/mountain_wave.h"
#include "cloud/repeat.h"
#include "core/alloc.h"
#include "core/math.h"

enum { TEXELS_PER_CELL = 48, TEXELS_MAX = 1 << 14 /* texels along a side */, HISTOGRAM_BINS = 4096 };

static const float clear_sky = -8.0f; /* height far below any waterline */

typedef struct map_job {
  np_weather_map *map;
  const np_weather_picture *picture;
  np_landscape landscape;
} map_job;

static size_t count_texels(const np_weather_map *map) { return (size_t)map->size[0] * (size_t)map->size[1]; }

static void sample_picture(const map_job *job, size_t first, size_t count, const np_landscape_out *at) {
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) {
    float *plane = job->map->planes[q];
    for (size_t i = 0; plane && job->picture->values[q] && i < count; i++)
      plane[first + i] = np_weather_picture_sample(job->picture, q, at->air_x_m[i], at->air_y_m[i]);
  }
}

static void fill_row(const map_job *job, int32_t row) {
  np_weather_map *map = job->map;
  float x[NP_LANDSCAPE_BLOCK], y[NP_LANDSCAPE_BLOCK];
  double air_x[NP_LANDSCAPE_BLOCK], air_y[NP_LANDSCAPE_BLOCK];
  for (int32_t begin = 0; begin < map->size[0]; begin += NP_LANDSCAPE_BLOCK) {
    const int32_t rest = map->size[0] - begin, count = rest < NP_LANDSCAPE_BLOCK ? rest : NP_LANDSCAPE_BLOCK;
    const size_t first = (size_t)row * (size_t)map->size[0] + (size_t)begin;
    for (int32_t i = 0; i < count; i++) {
      x[i] = map->origin_m[0] + (float)(begin + i) * map->step_m;
      y[i] = map->origin_m[1] + (float)row * map->step_m;
    }
    const np_landscape_out out = {map->values + first, map->anvils ? map->anvils + first : NULL, air_x, air_y};
    np_landscape_eval(&job->landscape, (size_t)count, x, y, &out);
    sample_picture(job, first, (size_t)count, &out);
  }
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) fill_row(user, (int32_t)row);
  return NEPH_OK;
}

static void compute_range(np_weather_map *map) {
  map->lowest = INFINITY;
  map->highest = -INFINITY;
  for (size_t i = 0; i < count_texels(map); i++) {
    const float height = map->values[i] - (map->levels ? map->levels[i] : 0.0f);
    map->lowest = fminf(map->lowest, height);
    map->highest = fmaxf(map->highest, height);
  }
}

/* Heights of the quantiles 0, 1/256, …, 1 of all texels. */
static neph_result compute_quantiles(np_weather_map *map) {
  const float bins_per_height = (float)HISTOGRAM_BINS / fmaxf(map->highest - map->lowest, 1e-6f);
  const double texel_count = (double)count_texels(map);
  size_t *histogram = np_alloc(map->context, HISTOGRAM_BINS + 1, sizeof *histogram), below = 0;
  if (!histogram) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count_texels(map); i++) histogram[(int)((map->values[i] - map->lowest) * bins_per_height)]++;
  int bin = 0;
  for (int k = 0; k <= NP_WEATHER_QUANTILES; k++) {
    const double wanted = texel_count * k / NP_WEATHER_QUANTILES;
    while (bin < HISTOGRAM_BINS && (double)(below + histogram[bin]) < wanted) below += histogram[bin++];
    const double inside = histogram[bin] ? (wanted - (double)below) / (double)histogram[bin] : 0.0;
    map->quantiles[k] = map->lowest + ((float)bin + (float)inside) / bins_per_height;
  }
  np_alloc_free(map->context, histogram);
  return NEPH_OK;
}

static float eval_quantile(const np_weather_map *map, float share) {
  const float scaled = np_clampf(share, 0.0f, 1.0f) * (float)NP_WEATHER_QUANTILES;
  int i = (int)scaled;
  if (i > NP_WEATHER_QUANTILES - 1) i = NP_WEATHER_QUANTILES - 1;
  return np_mixf(map->quantiles[i], map->quantiles[i + 1], scaled - (float)i);
}

/* Sets the levels from the picture's coverage. */
static void apply_coverage(np_weather_map *map) {
  const float *shares = map->planes[NEPH_CLOUD_MAP_COVERAGE], clear = map->highest - clear_sky;
  double sum = 0;
  for (size_t i = 0; i < count_texels(map); i++) {
    map->levels[i] = shares[i] > 0.0f ? eval_quantile(map, 1.0f - shares[i]) : clear;
    sum += (double)shares[i];
  }
  map->coverage = sum / (double)count_texels(map);
}

static neph_result allocate(np_weather_map *map, const neph_cloud_desc *desc, const np_weather_picture *picture) {
  const size_t texel_count = count_texels(map);
  bool is_done = (map->values = np_alloc(map->context, texel_count, sizeof *map->values)) != NULL;
  if (is_done && desc->anvil > 0 && np_cloud_kind_get(desc->model)->landscape.has_anvils)
    is_done = (map->anvils = np_alloc(map->context, texel_count, sizeof *map->anvils)) != NULL;
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT && is_done; q++)
    if (picture->values[q] || (q == NEPH_CLOUD_MAP_BASE && desc->ground_lift > 0 && np_cloud_desc_has_ground(desc)))
      is_done = (map->planes[q] = np_alloc(map->context, texel_count, sizeof *map->planes[q])) != NULL;
  if (is_done && picture->values[NEPH_CLOUD_MAP_COVERAGE])
    is_done = (map->levels = np_alloc(map->context, texel_count, sizeof *map->levels)) != NULL;
  return is_done ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result choose_texels(np_weather_map *map, const neph_cloud_desc *desc) {
  map->is_periodic = desc->repeat_m > 0;
  if (map->is_periodic) map->step_m = np_repeat_fit(desc, map->step_m);
  for (int i = 0; i < 2; i++) {
    const double count = map->is_periodic ? (double)np_repeat_count(desc->extent_m[i], (double)map->step_m)
                                          : ceil(desc->extent_m[i] / (double)map->step_m) + 2;
    if (count > TEXELS_MAX)
      return np_fail(map->context, NEPH_ERROR_LIMIT,
                     "%s.extent[%d] is %g m, must be at most %g times cell, which is %g m: enlarge cell",
                     np_cloud_desc_name(desc), i, desc->extent_m[i], (double)(TEXELS_MAX - 2) / TEXELS_PER_CELL,
                     desc->cell_m);
    map->size[i] = (int32_t)count;
    map->origin_m[i] = -0.5f * (float)(map->size[i] - (map->is_periodic ? 0 : 1)) * map->step_m;
  }
  return NEPH_OK;
}

static neph_result fill(np_weather_map *map, const neph_cloud_desc *desc, const np_weather_picture *picture,
                        const np_weather_map *start, np_monitor *monitor) {
  map_job job = {map, picture, np_landscape_make(np_noise_get_table(map->context->isa), desc)};
  neph_result result = np_parallel_for(map->context, monitor, (size_t)map->size[1], 4, fill_rows, &job);
  if (result) return result;
  result = np_ground_map_fill(map->context, desc, monitor, map);
  if (!result && job.landscape.rule->has_mountain_waves)
    result = np_mountain_wave_fill(map->context, desc, monitor, map);
  if (result) return result;
  np_ground_map_cover(desc, map);
  np_ground_map_lift(desc, map);
  compute_range(map);
  map->radius_m = job.landscape.radius_m;
  map->coverage = desc->coverage;
  if (!map->planes[NEPH_CLOUD_MAP_COVERAGE]) return NEPH_OK;
  if (start)
    memcpy(map->quantiles, start->quantiles, sizeof map->quantiles);
  else
    result = compute_quantiles(map);
  if (result) return result;
  apply_coverage(map);
  compute_range(map);
  return NEPH_OK;
}

neph_result np_weather_map_build(neph_context *context, const neph_cloud_desc *desc, const np_weather_picture *picture,
                                 const np_weather_map *start, np_monitor *monitor, np_weather_map *out_map) {
  np_weather_map map = {.context = context, .step_m = (float)(desc->cell_m / TEXELS_PER_CELL)};
  neph_result result = choose_texels(&map, desc);
  if (!result) result = allocate(&map, desc, picture);
  if (!result) result = fill(&map, desc, picture, start, monitor);
  if (result) {
    np_weather_map_clear(&map);
    return result;
  }
  *out_map = map;
  return NEPH_OK;
}
