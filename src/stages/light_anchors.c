/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/light_anchors.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "plan/scene_hash.h"
#include "scene/scene_eval.h"
#include "scene/sequence.h"
#include "stages/stage_part.h"

/* ---- Which frames ---- */

enum { BLOCK_MAX = 1 << 16, TURN_STEPS = 4 };

typedef struct directions {
  np_dvec3 sun, moon;
} directions;

static neph_result get_directions(const neph_scene *scene, double frame, directions *out) {
  neph_scene at;
  const neph_result result = np_scene_eval(scene, frame, &at);
  if (result) return result;
  const np_scene_lights lights = np_scene_lights_compute(&at, at.latitude_rad, at.longitude_rad);
  *out = (directions){lights.to_sun, lights.moon.direction};
  np_scene_eval_clear(&at);
  return NEPH_OK;
}

static double get_turn(np_dvec3 a, np_dvec3 b) { return np_dvec3_length(np_dvec3_subtract(a, b)); }

/* The way of sun or moon, whichever is longer, from one frame to another. */
static neph_result compute_turn(const neph_scene *scene, int first, int last, double *out_rad) {
  directions from, to;
  double sun = 0.0, moon = 0.0;
  neph_result result = get_directions(scene, first, &from);
  for (int i = 1; i <= TURN_STEPS && !result; i++) {
    result = get_directions(scene, first + ((double)last - first) * i / TURN_STEPS, &to);
    if (result) break;
    sun += get_turn(from.sun, to.sun);
    moon += scene->moon.is_enabled ? get_turn(from.moon, to.moon) : 0.0;
    from = to;
  }
  *out_rad = fmax(sun, moon);
  return result;
}

static int floor_to(int frame, int block) {
  const int rest = frame % block;
  return frame - (rest < 0 ? rest + block : rest);
}

/* Whether light can be interpolated at all in the pictures of a plan. */
static bool is_interpolated(const neph_scene *scene, const np_plan *plan) {
  return scene->render.light_reuse_rad > 0.0 && np_plan_needs(plan, NP_STAGE_ORDINATES) &&
         plan->desc.integrator == NEPH_INTEGRATOR_MARCH && plan->are_lights_known &&
         !isfinite(plan->desc.time_limit_s) && np_scene_is_sequence(scene) && !np_scene_has_still_light(scene);
}

neph_result np_light_span_choose(const neph_scene *scene, const np_plan *plan, np_light_span *out) {
  const int frame = plan->desc.frame;
  double turn = 0.0, within = 0.0;
  neph_result result = NEPH_OK;
  *out = (np_light_span){.frames = {frame, frame}};
  if (!is_interpolated(scene, plan)) return NEPH_OK;
  for (int block = 2; block <= BLOCK_MAX && !result; block *= 2) {
    const int first = floor_to(frame, block);
    if (!np_scene_stays_between(scene, first, first + block)) break;
    result = compute_turn(scene, first, first + block, &turn);
    if (result || turn > scene->render.light_reuse_rad) break;
    within = turn;
    *out = (np_light_span){{first, first + block}, 0.0};
  }
  /* While the sun rests every frame has the same light. */
  if (within == 0.0)
    *out = (np_light_span){.frames = {frame, frame}};
  else if (!result)
    result = compute_turn(scene, out->frames[0], frame, &out->share);
  out->share = within > 0.0 ? fmin(out->share / within, 1.0) : 0.0;
  return result;
}

/* ---- Their light ---- */

/* The light of a frame, solved for at an end of a block. */
typedef struct light_anchor {
  char id[33]; /* fingerprint of scene, settings and frame; empty: none */
  unsigned count;
  np_light_solution *solutions;
} light_anchor;

typedef struct light_anchors {
  light_anchor at[2];
} light_anchors;

static void clear_anchor(neph_context *context, light_anchor *anchor) {
  for (unsigned i = 0; i < anchor->count; i++) {
    np_alloc_free(context, anchor->solutions[i].key);
    np_scattering_field_destroy(anchor->solutions[i].field);
  }
  np_alloc_free(context, anchor->solutions);
  *anchor = (light_anchor){.count = 0};
}

static void destroy_anchors(neph_context *context, void *light) {
  light_anchors *anchors = light;
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

/* Takes the solutions out of an assembly, with the keys by which they were solved for. */
static neph_result take_solutions(np_assembly *a, light_anchor *out) {
  const unsigned count = a->packet_count * a->light_count;
  out->solutions = np_alloc(a->context, count, sizeof *out->solutions);
  if (!out->solutions) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < count; i++) {
    np_packet_light *light = &a->packets[i / a->light_count].lights[i % a->light_count];
    const unsigned slot = i / a->light_count * NP_LIGHTS_MAX + light->group;
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
static neph_result solve_planned(const neph_scene *scene, np_plan *plan, np_stores *stores, np_monitor *monitor,
                                 light_anchor *out) {
  const np_build_job job = np_build_job_make(stores);
  np_assembly assembly;
  neph_result result = np_plan_fit_memory(scene, plan, &stores->inputs);
  if (result || !np_plan_needs(plan, NP_STAGE_ORDINATES)) return result;
  np_log(scene->context, NEPH_LOG_INFO, "multiple scattering: solved for at frame %d, to be interpolated from",
         plan->desc.frame);
  result = np_assembly_build_some(scene, plan, collect_stages(NP_STAGE_ORDINATES), &job, monitor, &assembly);
  if (result) return result;
  result = take_solutions(&assembly, out);
  np_assembly_clear(&assembly);
  return result;
}

/* The light at an end of the block; nothing is in that of a frame that has none. */
static neph_result solve(const neph_scene *scene, const np_plan *plan, int end, np_stores *stores, np_monitor *monitor,
                         light_anchor *out) {
  neph_scene at;
  np_plan *at_frame;
  neph_render_desc desc = plan->desc;
  desc.frame = plan->light_span.frames[end];
  desc.part_path = desc.checkpoint_path = NULL;
  desc.is_resumed = false;
  neph_result result = np_plan_create_frame(scene, &desc, &at, &at_frame);
  if (!result) {
    at_frame->light_checkpoints = plan->light_checkpoints;
    at_frame->light_checkpoints.block_end = (unsigned)end + 1;
    result = solve_planned(&at, at_frame, stores, monitor, out);
  }
  np_plan_destroy(scene->context, at_frame);
  np_scene_eval_clear(&at);
  return result;
}

static neph_result compute_id(const neph_scene *scene, const np_plan *plan, int frame, char out[33]) {
  neph_render_desc desc = plan->desc;
  desc.frame = frame;
  return np_scene_hash_compute(scene, &desc, plan->savings, out);
}

/* Puts the anchor of an id, if there is one, at its end of the span. */
static void arrange(light_anchors *anchors, char ids[2][33]) {
  const bool is_crossed = !strcmp(anchors->at[0].id, ids[1]) || !strcmp(anchors->at[1].id, ids[0]);
  if (!is_crossed) return;
  const light_anchor first = anchors->at[0];
  anchors->at[0] = anchors->at[1];
  anchors->at[1] = first;
}

neph_result np_light_anchors_solve(const neph_scene *scene, const np_plan *plan, np_stores *stores,
                                   np_monitor *monitor) {
  char ids[2][33];
  neph_result result = NEPH_OK;
  if (!stores->light) stores->light = np_alloc(scene->context, 1, sizeof(light_anchors));
  if (!stores->light) return NEPH_ERROR_OUT_OF_MEMORY;
  stores->destroy_light = destroy_anchors;
  light_anchors *anchors = stores->light;
  for (int i = 0; i < 2 && !result; i++) result = compute_id(scene, plan, plan->light_span.frames[i], ids[i]);
  if (result) return result;
  arrange(anchors, ids);
  for (int i = 0; i < 2 && !result; i++) {
    light_anchor *anchor = &anchors->at[i];
    if (*ids[i] && !strcmp(anchor->id, ids[i])) continue;
    clear_anchor(scene->context, anchor);
    if (*ids[i]) result = solve(scene, plan, i, stores, monitor, anchor);
    if (result)
      clear_anchor(scene->context, anchor);
    else
      memcpy(anchor->id, ids[i], sizeof anchor->id);
  }
  return result;
}

bool np_light_anchors_get(const np_plan *plan, const np_stores *stores, unsigned slot,
                          const np_light_solution *out[2]) {
  const light_anchors *anchors = stores->light;
  if (!anchors || plan->light_span.frames[0] == plan->light_span.frames[1]) return false;
  for (int i = 0; i < 2; i++) {
    out[i] = NULL;
    for (unsigned k = 0; k < anchors->at[i].count; k++)
      if (anchors->at[i].solutions[k].slot == slot) out[i] = &anchors->at[i].solutions[k];
  }
  return out[0] && out[1] && np_scattering_field_can_blend(out[0]->field, out[1]->field);
}
