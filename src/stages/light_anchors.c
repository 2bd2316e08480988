/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/light_anchors.h"

#include <string.h>

#include "core/alloc.h"
#include "plan/scene_hash.h"
#include "scene/scene_eval.h"
#include "stages/stage_part.h"

static void clear_anchor(neph_context *context, np_light_anchor *anchor) {
  for (unsigned i = 0; i < anchor->count; i++) {
    np_alloc_free(context, anchor->solutions[i].key);
    np_scattering_field_destroy(anchor->solutions[i].field);
  }
  np_alloc_free(context, anchor->solutions);
  *anchor = (np_light_anchor){.count = 0};
}

static void destroy_anchors(neph_context *context, void *light) {
  np_light_anchors *anchors = light;
  for (int i = 0; i < 2; i++) clear_anchor(context, &anchors->at[i]);
  np_alloc_free(context, anchors);
}

/* A stage and all that it needs. */
static uint32_t collect_stages(np_stage stage) {
  uint32_t all = 1u << stage, needs = np_stage_get_rule(stage)->needs;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (needs & 1u << i) all |= collect_stages((np_stage)i);
  return all;
}

/* Moves the solutions out of an assembly, with their keys. */
static neph_result take_solutions(np_assembly *a, np_light_anchor *out) {
  const unsigned count = a->packet_count * a->lights.count;
  out->solutions = np_alloc(a->context, count, sizeof *out->solutions);
  if (!out->solutions) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < count; i++) {
    np_packet_light *light = &a->packets[i / a->lights.count].lights[i % a->lights.count];
    const unsigned slot = i / a->lights.count * NP_LIGHTS_MAX + light->beam.group;
    const np_stored_result *own = np_stores_search(a->stores, &np_stage_reuse_ordinates, slot);
    if (!light->scattering || !own) continue;
    np_light_solution *solution = &out->solutions[out->count];
    solution->key = np_alloc(a->context, 1, sizeof *solution->key);
    if (!solution->key) return NEPH_ERROR_OUT_OF_MEMORY;
    memcpy(solution->key, own->key, sizeof *solution->key);
    solution->slot = slot;
    solution->field = light->scattering;
    light->scattering = NULL;
    out->count++;
  }
  return NEPH_OK;
}

/* Solves in the evaluated frame of a plan. */
static neph_result solve_planned(const neph_scene *scene, np_plan *plan, const np_build_job *job, np_monitor *monitor,
                                 np_light_anchor *out) {
  np_assembly assembly;
  neph_result result = np_plan_fit_memory(scene, plan, &job->stores->inputs);
  if (result || !np_plan_needs(plan, NP_STAGE_ORDINATES)) return result;
  np_log(scene->context, NEPH_LOG_INFO, "multiple scattering: solved for at frame %d, to be interpolated from",
         plan->request.desc.frame);
  result = np_assembly_build_some(scene, plan, collect_stages(NP_STAGE_ORDINATES), job, monitor, &assembly);
  if (result) return result;
  result = take_solutions(&assembly, out);
  np_assembly_clear(&assembly);
  return result;
}

/* Solves for the light at an end of the block; a frame without light has no solutions. */
static neph_result solve(const neph_scene *scene, const np_request *request, const np_build_job *picture, int end,
                         np_monitor *monitor, np_light_anchor *out) {
  neph_scene at;
  np_plan plan;
  neph_render_desc desc = request->desc;
  np_build_job job = np_build_job_make(picture->stores);
  job.light_checkpoints = np_light_checkpoints_make(&desc, (unsigned)end + 1);
  desc.frame = picture->light_span.frames[end];
  desc.part_path = desc.checkpoint_path = NULL;
  desc.is_resumed = false;
  neph_result result = np_plan_make_frame(scene, &desc, &at, &plan);
  if (!result) result = solve_planned(&at, &plan, &job, monitor, out);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result;
}

static neph_result compute_id(const neph_scene *scene, const np_plan *plan, int frame, char out[33]) {
  neph_render_desc desc = plan->request.desc;
  desc.frame = frame;
  return np_scene_hash_compute(scene, &desc, plan->savings.text, out);
}

/* Moves the anchor with an id, if it exists, to the matching end of the span. */
static void swap_crossed(np_light_anchors *anchors, char ids[2][33]) {
  const bool is_crossed = !strcmp(anchors->at[0].id, ids[1]) || !strcmp(anchors->at[1].id, ids[0]);
  if (!is_crossed) return;
  const np_light_anchor first = anchors->at[0];
  anchors->at[0] = anchors->at[1];
  anchors->at[1] = first;
}

neph_result np_light_anchors_solve(const neph_scene *scene, const np_plan *plan, const np_build_job *job,
                                   np_monitor *monitor) {
  np_stores *stores = job->stores;
  char ids[2][33];
  neph_result result = NEPH_OK;
  if (!stores->light) stores->light = np_alloc(scene->context, 1, sizeof(np_light_anchors));
  if (!stores->light) return NEPH_ERROR_OUT_OF_MEMORY;
  stores->destroy_light = destroy_anchors;
  np_light_anchors *anchors = stores->light;
  for (int i = 0; i < 2 && !result; i++) result = compute_id(scene, plan, job->light_span.frames[i], ids[i]);
  if (result) return result;
  swap_crossed(anchors, ids);
  for (int i = 0; i < 2 && !result; i++) {
    np_light_anchor *anchor = &anchors->at[i];
    if (*ids[i] && !strcmp(anchor->id, ids[i])) continue;
    clear_anchor(scene->context, anchor);
    if (*ids[i]) result = solve(scene, &plan->request, job, i, monitor, anchor);
    if (result)
      clear_anchor(scene->context, anchor);
    else
      memcpy(anchor->id, ids[i], sizeof anchor->id);
  }
  return result;
}
