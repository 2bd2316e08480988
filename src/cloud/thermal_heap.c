/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/thermal_heap.h"

#include <math.h>

#include "cloud/billows.h"
#include "cloud/census.h"
#include "cloud/shape.h"
#include "cloud/shape_desc.h"
#include "cloud/thermals.h"
#include "cloud/waterline.h"
#include "core/alloc.h"
#include "core/math.h"

static const float thermal_blend = 0.13f; /* in largest billows */

neph_result np_thermals_build(np_cloud_model *model, np_monitor *monitor, unsigned level_count) {
  const float billow_m = model->thermals.billow_m;
  np_ball_heap_cut(&model->balls, 0);
  if (model->is_empty) return NEPH_OK;
  const bool has_shape = np_cloud_desc_has_shape(&model->desc);
  neph_result result = (has_shape ? np_shape_add_balls
                                  : np_thermals_add_stacks)(model, monitor, thermal_blend * billow_m, 0.5f * billow_m);
  for (unsigned level = 1; level < level_count && !result; level++)
    result = np_thermals_add_billows(model, monitor, level);
  return result;
}

/* ---- Projection ---- */

enum { SHADOW_EDGE = 128, BALLS_PER_PIECE = 1024 };

typedef uint8_t shadow_map[SHADOW_EDGE * SHADOW_EDGE];

static void cast_shadow(const neph_cloud_desc *desc, const np_ball *ball, uint8_t *is_covered) {
  const float cell_m[2] = {(float)desc->extent_m[0] / SHADOW_EDGE, (float)desc->extent_m[1] / SHADOW_EDGE};
  const float at_m[2] = {ball->x_m + 0.5f * (float)desc->extent_m[0], ball->y_m + 0.5f * (float)desc->extent_m[1]};
  int low[2], high[2];
  for (int a = 0; a < 2; a++) {
    low[a] = (int)np_clampf((at_m[a] - ball->radius_m) / cell_m[a], 0.0f, SHADOW_EDGE);
    high[a] = (int)np_clampf((at_m[a] + ball->radius_m) / cell_m[a] + 1.0f, 0.0f, SHADOW_EDGE);
  }
  for (int i = low[0]; i < high[0]; i++)
    for (int j = low[1]; j < high[1]; j++) {
      const float x = ((float)i + 0.5f) * cell_m[0] - at_m[0], y = ((float)j + 0.5f) * cell_m[1] - at_m[1];
      if (x * x + y * y < ball->radius_m * ball->radius_m) is_covered[i * SHADOW_EDGE + j] = 1;
    }
}

typedef struct shadow_job {
  const neph_cloud_desc *desc;
  const np_ball_level *level;
  shadow_map *is_covered; /* marks of each thread's balls */
} shadow_job;

static neph_result cast_shadows(void *user, size_t begin, size_t end, unsigned thread) {
  const shadow_job *job = user;
  for (size_t i = begin; i < end; i++) {
    const np_ball ball = np_ball_level_get(job->level, i);
    cast_shadow(job->desc, &ball, job->is_covered[thread]);
  }
  return NEPH_OK;
}

static double compute_cover(shadow_map *is_covered, unsigned thread_count) {
  size_t count = 0;
  for (int i = 0; i < SHADOW_EDGE * SHADOW_EDGE; i++) {
    bool is_any = false;
    for (unsigned t = 0; t < thread_count; t++) is_any = is_any || is_covered[t][i];
    count += is_any;
  }
  return (double)count / (SHADOW_EDGE * SHADOW_EDGE);
}

/* Share of the field below the stacks of thermals, from their waterline; leaves the heap empty. */
static neph_result count_shadow(np_cloud_model *model, np_monitor *monitor, double *out_fraction) {
  neph_context *context = model->balls.context;
  const unsigned threads = neph_context_get_thread_count(context);
  shadow_job job = {.desc = &model->desc, .is_covered = np_alloc(context, threads, sizeof *job.is_covered)};
  if (!job.is_covered) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_thermals_build(model, monitor, 1);
  for (unsigned l = 0; l < model->balls.level_count && !result; l++) {
    job.level = &model->balls.levels[l];
    result = np_parallel_for(context, monitor, job.level->count, BALLS_PER_PIECE, cast_shadows, &job);
  }
  *out_fraction = compute_cover(job.is_covered, threads);
  np_alloc_free(context, job.is_covered);
  np_ball_heap_cut(&model->balls, 0);
  return result;
}

/* ---- Waterline ---- */

/* Shadows by waterline: searches begin alike, and differ in their last steps. */
typedef struct known_shadows {
  size_t count;
  struct {
    float waterline;
    double fraction;
  } at[64];
} known_shadows;

/* Sets a waterline, and counts its shadow unless it is known. */
static neph_result get_shadow(np_cloud_model *model, np_monitor *monitor, float waterline, known_shadows *known,
                              double *out_fraction) {
  np_waterline_set(model, waterline);
  for (size_t i = 0; i < known->count; i++)
    if (known->at[i].waterline == waterline) return *out_fraction = known->at[i].fraction, NEPH_OK;
  const neph_result result = count_shadow(model, monitor, out_fraction);
  if (result || known->count == sizeof known->at / sizeof *known->at) return result;
  known->at[known->count].waterline = waterline;
  known->at[known->count++].fraction = *out_fraction;
  return NEPH_OK;
}

static neph_result search_shadow(np_cloud_model *model, np_monitor *monitor, double wanted, known_shadows *known) {
  const float spread = model->map.highest - model->map.lowest;
  float low = model->map.lowest - 0.5f * spread, high = model->map.highest - 0.01f * spread;
  const int steps = np_waterline_count_steps(model);
  for (int step = 0; step < steps; step++) {
    double fraction = 0;
    const float middle = 0.5f * (low + high);
    const neph_result result = get_shadow(model, monitor, middle, known, &fraction);
    if (result) return result;
    *(fraction > wanted ? &low : &high) = middle;
  }
  np_waterline_set(model, 0.5f * (low + high));
  return NEPH_OK;
}

/* Largest number of corrections of the projected cover, which does not include anvils. */
static int count_corrections(const np_cloud_model *model) {
  enum { CORRECTIONS = 3, CORRECTIONS_MAX = 8 };
  if (model->is_sketch) return model->map.anvils || model->map.levels ? CORRECTIONS : 1;
  return model->map.anvils || np_waterline_is_best(model) ? CORRECTIONS_MAX : CORRECTIONS;
}

/* Searches the waterline of thermals by the vertical projection of their stacks, several times: the census of the
 * complete cloud corrects the requested projection. */
neph_result np_thermals_search_waterline(np_cloud_model *model, np_monitor *monitor) {
  enum { CENSUS_LEVELS = 3 };
  const int corrections = count_corrections(model);
  const unsigned levels = np_thermals_count_levels(model);
  const double tolerance = model->map.levels ? 0.01 * model->map.coverage : 0.01;
  double wanted = model->map.coverage;
  np_waterline best = {.miss = INFINITY};
  known_shadows known = {.count = 0};
  if (model->is_empty) return NEPH_OK;
  neph_result result = search_shadow(model, monitor, wanted, &known);
  for (int n = 0; n < corrections && !result; n++) {
    double fraction = 0;
    result = np_thermals_build(model, monitor, levels < CENSUS_LEVELS ? levels : CENSUS_LEVELS);
    if (!result) result = np_census_count(model, monitor, &fraction);
    np_waterline_update_best(model, fraction, &best);
    if (result || best.miss < tolerance) break;
    wanted *= fmin(fmax(model->map.coverage / fmax(fraction, 1e-3), 0.3), 2.0);
    result = search_shadow(model, monitor, fmin(wanted, 1), &known);
  }
  if (np_waterline_is_best(model) && corrections > 1) np_waterline_set(model, best.value);
  return result;
}
