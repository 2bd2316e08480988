/* SPDX-License-Identifier: Apache-2.0 */
/* Memory of a picture, predicted from its plan. */
#include <math.h>
#include <string.h>

#include "core/given.h"
#include "core/text.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"
#include "scene/scene_eval.h"

/* Working memory of bakes and of readers of files, the same for volumes of any size. */
static double get_working_bytes(const np_plan *plan) {
  static const np_cost_unit units[] = {NP_UNIT_BAKE, NP_UNIT_READ_FILE};
  const np_cost_counts *counts = &plan->forecast.stages[NP_STAGE_VOLUMES].counts;
  np_cost_counts working = {.of = {0.0}};
  for (size_t i = 0; i < sizeof units / sizeof *units; i++) working.of[units[i]] = counts->of[units[i]];
  return np_costs_sum(&working).bytes;
}

/* Bytes of leaves of the grids from which ice is built, which are freed before there is light or a picture. */
static double get_split_bytes(const np_plan *plan) {
  return (double)sizeof(np_leaf) / NP_LEAF_SIZE * np_plan_get_split_voxels(plan);
}

static neph_memory_estimate estimate(const np_plan *plan) {
  const np_stage_forecast *stages = plan->forecast.stages;
  const double film = stages[NP_STAGE_INTEGRATOR].cost.bytes, all = stages[NP_STAGE_VOLUMES].cost.bytes,
               terrain = stages[NP_STAGE_TERRAIN].cost.bytes, working = fmin(get_working_bytes(plan), all),
               volumes = all - working;
  neph_memory_estimate e = {.struct_size = sizeof e,
                            .program_bytes = (uint64_t)(np_costs_sum(&plan->forecast.program).bytes + working),
                            .terrain_bytes = (uint64_t)terrain,
                            .volume_bytes = (uint64_t)volumes,
                            .light_bytes =
                                (uint64_t)fmax(np_forecast_sum(&plan->forecast).bytes - film - all - terrain, 0.0),
                            .film_bytes = (uint64_t)film};
  e.volume_bytes += (uint64_t)fmax(get_split_bytes(plan) - (double)(e.light_bytes + e.film_bytes), 0.0);
  e.total_bytes = e.program_bytes + e.terrain_bytes + e.volume_bytes + e.light_bytes + e.film_bytes;
  return e;
}

double np_plan_predict_memory(const np_plan *plan) { return (double)estimate(plan).total_bytes; }

neph_result neph_render_estimate_memory(const neph_scene *scene, const neph_render_desc *desc,
                                        neph_memory_estimate *out_estimate) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_estimate)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene at;
  np_plan plan;
  neph_memory_estimate e;
  np_input_store store = {.references = NULL};
  neph_result result = np_desc_check_size(scene->context, "neph_memory_estimate", out_estimate, sizeof *out_estimate);
  if (result) return result;
  result = np_plan_make_frame(scene, desc, &at, &plan);
  if (!result) result = np_plan_measure_fill(&at, &plan, &store);
  if (!result) e = estimate(&plan);
  np_input_store_clear(scene->context, &store);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result ? result : np_desc_write(scene->context, "neph_memory_estimate", &e, sizeof e, out_estimate);
}

/* ---- Fitting a limit ---- */

static bool has_floats(const neph_scene *scene, const np_plan *plan) {
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (np_plan_get_precision(plan, &scene->clouds[i]) == NEPH_PRECISION_FLOAT) return true;
  return false;
}

/* Least share of its memory with which multiple scattering is solved for at all: cells four times as wide. */
static const double light_share_min = 1.0 / 64.0;

/* Memory of the fewest cells of a solution, eight along each axis, of 1.65 kB each. */
static const double light_bytes_min = 1e6;

/* Adds a saving to the plan, and revises the plan. */
static neph_result add_saving(const neph_scene *scene, np_plan *plan, const char *what, neph_memory_estimate *e) {
  char *text = plan->savings.text;
  const size_t length = strlen(text);
  np_print(text + length, sizeof plan->savings.text - length, "%s%s", length ? ", and " : "", what);
  neph_result result = np_plan_revise(scene, plan);
  if (!result) *e = estimate(plan);
  return result;
}

static neph_result fit_light(const neph_scene *scene, np_plan *plan, neph_memory_estimate *e) {
  const double light = plan->forecast.stages[NP_STAGE_ORDINATES].cost.bytes;
  const double left = light - ((double)e->total_bytes - (double)plan->request.desc.memory_max_bytes);
  char text[96];
  if (!(left > fmax(light_share_min * light, light_bytes_min))) return NEPH_OK;
  plan->savings.light_bytes_max = left; /* the limit is kept even where all bytes of cells are resident */
  np_print(text, sizeof text, "multiple scattering is solved for on coarser cells, in %.3g of %.3g GB", 1e-9 * left,
           1e-9 * light);
  return add_saving(scene, plan, text, e);
}

/* Bakes may be read from files too. */
static bool has_file(const neph_scene *scene, bool is_bake_counted) {
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    const np_scene_cloud *cloud = &scene->clouds[i];
    if (cloud->vdb && !cloud->volume && (is_bake_counted || !cloud->is_baked)) return true;
  }
  return false;
}

static bool has_levels(const neph_scene *scene, const np_plan *plan) {
  bool has = false;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    has = has || (scene->clouds[i].vdb && scene->clouds[i].level_count > 1) ||
          np_inputs_get_file(&plan->inputs, i)->level_count > 1;
  return has;
}

static const char coarse_files[] = "voxels of files are twice as long",
                  coarse_levels[] = "voxels of files, of levels of detail those of the finest, are twice as long";

static neph_result fit(const neph_scene *scene, np_plan *plan, neph_memory_estimate *e) {
  const uint64_t allowed = plan->request.desc.memory_max_bytes;
  neph_result result = NEPH_OK;
  if (e->total_bytes > allowed && has_floats(scene, plan)) {
    plan->savings.are_halves = true;
    result = add_saving(scene, plan, "volumes are kept in halves instead of floats", e);
  }
  if (!result && e->total_bytes > allowed) result = fit_light(scene, plan, e);
  if (result || e->total_bytes <= allowed || !has_file(scene, true)) return result;
  plan->savings.are_coarse = true;
  result = add_saving(scene, plan, has_levels(scene, plan) ? coarse_levels : coarse_files, e);
  return result || e->total_bytes <= allowed ? result : fit_light(scene, plan, e);
}

/* Advice that makes the largest part smaller. */
static const char *advise(const neph_scene *scene, const neph_memory_estimate *e) {
  const struct {
    uint64_t bytes;
    const char *advice;
  } parts[] = {
      {e->volume_bytes, has_file(scene, false) ? "take a file of longer voxels" : "enlarge clouds[].bake.voxel"},
      {e->light_bytes, "lessen the resolution, or enlarge clouds[].bake.voxel or the voxels of files"},
      {e->terrain_bytes, "take a terrain of fewer heights or triangles"},
      {e->film_bytes, "lessen the resolution, or render in tiles"},
      {e->program_bytes, "allow more: the program alone takes most of it"}};
  unsigned largest = 0;
  for (unsigned i = 1; i < sizeof parts / sizeof *parts; i++)
    if (parts[i].bytes > parts[largest].bytes) largest = i;
  return parts[largest].advice;
}

static neph_result refuse(const neph_scene *scene, const np_plan *plan, const neph_memory_estimate *e) {
  return np_fail(scene->context, NEPH_ERROR_LIMIT,
                 "the render needs about %.3g GB (volumes %.3g, light %.3g, terrain %.3g, picture %.3g, program %.3g), "
                 "must be at most %.3g GB: %s",
                 1e-9 * (double)e->total_bytes, 1e-9 * (double)e->volume_bytes, 1e-9 * (double)e->light_bytes,
                 1e-9 * (double)e->terrain_bytes, 1e-9 * (double)e->film_bytes, 1e-9 * (double)e->program_bytes,
                 1e-9 * (double)plan->request.desc.memory_max_bytes, advise(scene, e));
}

/* Bytes of the cells of multiple scattering as np_scattering_desc counts them; some are freed before others are
 * allocated. */
static double get_cell_bytes(const np_plan *plan) {
  return plan->forecast.stages[NP_STAGE_ORDINATES].counts.of[NP_UNIT_CELL_BYTE];
}

/* Gives multiple scattering the memory that the plan leaves within the limit: clouds of files may be denser than their
 * headers say, and cells smaller. Bakes are counted before. */
static void limit_light(const neph_scene *scene, np_plan *plan, const neph_memory_estimate *e) {
  if (!has_file(scene, false)) return;
  const double rest = (double)plan->request.desc.memory_max_bytes - (double)e->total_bytes;
  plan->savings.light_bytes_max = fmin(plan->savings.light_bytes_max, get_cell_bytes(plan) + rest);
}

static neph_result fit_measured(const neph_scene *scene, np_plan *plan) {
  const uint64_t allowed = plan->request.desc.memory_max_bytes;
  const neph_memory_estimate e = estimate(plan);
  neph_memory_estimate least = e;
  if (e.total_bytes <= allowed) return limit_light(scene, plan, &e), NEPH_OK;
  const neph_result result = fit(scene, plan, &least);
  if (result) return result;
  if (least.total_bytes > allowed) return refuse(scene, plan, &e);
  np_log(scene->context, NEPH_LOG_WARNING, "to stay within %.3g GB of memory, %s", 1e-9 * (double)allowed,
         plan->savings.text);
  return NEPH_OK;
}

neph_result np_plan_fit_memory(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  if (plan->request.desc.memory_max_bytes == NEPH_MEMORY_UNLIMITED) return NEPH_OK;
  neph_result result = np_plan_measure_fill(scene, plan, store);
  if (!result) result = fit_measured(scene, plan);
  np_inputs_drop_trial(&plan->inputs, store);
  return result;
}
