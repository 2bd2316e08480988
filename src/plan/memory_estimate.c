/* SPDX-License-Identifier: Apache-2.0 */
/* Memory of a picture, predicted from its plan. */
#include <math.h>
#include <string.h>

#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "image/image_private.h"
#include "plan/plan.h"
#include "plan/plan_detail.h"
#include "plan/stage_rules.h"
#include "scene/scene_eval.h"

/* Memory of a program with the library alone, and memory of OpenVDB and the libraries that come with it. */
static const double program_bytes = 14e6, vdb_bytes = 31e6;

/* Memory of a height: itself, its vertex, and Embree's tree. */
static const double height_bytes = 38.0;

/* Memory of a byte of a mesh's file: its vertices and triangles, Embree's tree, and Assimp's copy while it is read. */
static const double mesh_byte_bytes = 6.0;

/* Samples along a side that go on beyond the border of a file. */
static const double margin_samples = 160.0;

/* Heights of a terrain that will be built; a given one is there already. */
static neph_result count_heights(const neph_scene *scene, const np_plan *plan, double *out_count) {
  const np_scene_terrain *terrain = &scene->terrain;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  const np_terrain_row *row = &np_terrain_rows[terrain->kind];
  unsigned size[2] = {0, 0};
  if (terrain->kind == NP_TERRAIN_RIDGES) size[0] = size[1] = np_plan_get_ridges(&plan->request, scene).sample_count;
  neph_result result = row->check ? row->check(scene->context, &source, &terrain->desc, size) : NEPH_OK;
  const bool has_margin = row->check && terrain->desc.edge == NEPH_TERRAIN_EDGE_INFINITE;
  const double margin = has_margin ? margin_samples : 0.0;
  *out_count = (size[0] + margin) * (size[1] + margin);
  return result;
}

/* The terrain's bytes, with three floats for each texel of a picture of its albedo. */
static neph_result count_terrain_bytes(const neph_scene *scene, const np_plan *plan, double *out_bytes) {
  double heights;
  unsigned size[2] = {0, 0};
  neph_result result = count_heights(scene, plan, &heights);
  if (!result && scene->terrain.albedo_image)
    result = np_image_read_size(scene->context, scene->terrain.albedo_image, size);
  const double mesh = scene->terrain.mesh_file ? (double)np_file_get_size(scene->terrain.mesh_file) : 0.0;
  *out_bytes = height_bytes * heights + mesh_byte_bytes * mesh + 3.0 * sizeof(float) * (double)size[0] * size[1];
  return result;
}

static bool has_vdb(const neph_scene *scene) {
  bool has = false;
  for (unsigned i = 0; i < scene->cloud_count; i++) has = has || scene->clouds[i].vdb;
  return has;
}

static neph_result estimate(const neph_scene *scene, const np_plan *plan, neph_memory_estimate *out) {
  double terrain;
  neph_result result = count_terrain_bytes(scene, plan, &terrain);
  if (result) return result;
  const np_stage_forecast *stages = plan->forecast.stages;
  const double film = stages[NP_STAGE_INTEGRATOR].cost.bytes, volumes = stages[NP_STAGE_VOLUMES].cost.bytes;
  const double heights = stages[NP_STAGE_TERRAIN].cost.bytes;
  neph_memory_estimate e = {.struct_size = sizeof e,
                            .program_bytes = (uint64_t)(program_bytes + (has_vdb(scene) ? vdb_bytes : 0.0)),
                            .terrain_bytes = (uint64_t)terrain,
                            .volume_bytes = (uint64_t)volumes,
                            .light_bytes =
                                (uint64_t)(np_forecast_sum(&plan->forecast).bytes - film - volumes - heights),
                            .film_bytes = (uint64_t)film};
  e.total_bytes = e.program_bytes + e.terrain_bytes + e.volume_bytes + e.light_bytes + e.film_bytes;
  *out = e;
  return NEPH_OK;
}

neph_result np_plan_predict_memory(const neph_scene *scene, const np_plan *plan, double *out_bytes) {
  neph_memory_estimate e;
  neph_result result = estimate(scene, plan, &e);
  if (!result) *out_bytes = (double)e.total_bytes;
  return result;
}

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
  if (!result) result = estimate(&at, &plan, &e);
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

/* That of the fewest cells that there are, of 1.65 kB, eight along each axis. */
static const double light_bytes_min = 1e6;

/* Adds a saving, and decides again. */
static neph_result add_saving(const neph_scene *scene, np_plan *plan, const char *what, neph_memory_estimate *e) {
  char *text = plan->savings.text;
  const size_t length = strlen(text);
  np_print(text + length, sizeof plan->savings.text - length, "%s%s", length ? ", and " : "", what);
  neph_result result = np_plan_revise(scene, plan);
  return result ? result : estimate(scene, plan, e);
}

static neph_result fit_light(const neph_scene *scene, np_plan *plan, neph_memory_estimate *e) {
  const double light = plan->forecast.stages[NP_STAGE_ORDINATES].cost.bytes;
  const double left = light - ((double)e->total_bytes - (double)plan->request.desc.memory_max_bytes);
  char text[96];
  if (!(left > fmax(light_share_min * light, light_bytes_min))) return NEPH_OK;
  plan->savings.light_bytes_max = left;
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

static neph_result refuse(const neph_scene *scene, const np_plan *plan, const neph_memory_estimate *e) {
  return np_fail(
      scene->context, NEPH_ERROR_LIMIT,
      "the render needs about %.3g GB (volumes %.2g, light %.2g, terrain %.2g, picture %.2g), must be at most "
      "%.3g GB: lessen the resolution, enlarge clouds[].bake.voxel, or render in tiles",
      1e-9 * (double)e->total_bytes, 1e-9 * (double)e->volume_bytes, 1e-9 * (double)e->light_bytes,
      1e-9 * (double)e->terrain_bytes, 1e-9 * (double)e->film_bytes,
      1e-9 * (double)plan->request.desc.memory_max_bytes);
}

/* A plan within the limit leaves the rest of it to light: clouds of files may turn out denser than their headers say,
 * and cells of light smaller. Bakes are counted before. */
static void limit_light(const neph_scene *scene, np_plan *plan, const neph_memory_estimate *e) {
  if (!has_file(scene, false)) return;
  const double rest = (double)plan->request.desc.memory_max_bytes - (double)e->total_bytes;
  plan->savings.light_bytes_max =
      fmin(plan->savings.light_bytes_max, plan->forecast.stages[NP_STAGE_ORDINATES].cost.bytes + rest);
}

neph_result np_plan_fit_memory(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  const uint64_t allowed = plan->request.desc.memory_max_bytes;
  if (allowed == NEPH_MEMORY_UNLIMITED) return NEPH_OK;
  neph_memory_estimate e, least;
  neph_result result = np_plan_measure_fill(scene, plan, store);
  if (!result) result = estimate(scene, plan, &e);
  if (!result && e.total_bytes <= allowed) limit_light(scene, plan, &e);
  if (result || e.total_bytes <= allowed) return result;
  least = e;
  result = fit(scene, plan, &least);
  if (result) return result;
  if (least.total_bytes > allowed) return refuse(scene, plan, &e);
  np_log(scene->context, NEPH_LOG_WARNING, "to stay within %.3g GB of memory, %s", 1e-9 * (double)allowed,
         plan->savings.text);
  return NEPH_OK;
}
