/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/light_span.h"

#include <assert.h>
#include <math.h>

#include "scene/scene_eval.h"
#include "scene/sequence.h"

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

/* Angle by which the sun or the moon moves between two frames, whichever is larger. */
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
  assert(block > 0 && (block & (block - 1)) == 0);
  const int rest = frame % block;
  return frame - (rest < 0 ? rest + block : rest);
}

/* Whether light can be interpolated at all in the pictures of a plan. */
static bool is_interpolated(const neph_scene *scene, const np_plan *plan) {
  return scene->render.light_reuse_rad > 0.0 && np_plan_needs(plan, NP_STAGE_ORDINATES) &&
         plan->request.desc.integrator == NEPH_INTEGRATOR_MARCH && plan->decisions.are_lights_known &&
         !isfinite(plan->request.desc.time_limit_s) && np_scene_is_sequence(scene) && !np_scene_has_still_light(scene);
}

neph_result np_light_span_choose(const neph_scene *scene, const np_plan *plan, np_light_span *out) {
  const int frame = plan->request.desc.frame;
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
  /* While the sun does not move, one frame's light is valid for all. */
  if (within == 0.0)
    *out = (np_light_span){.frames = {frame, frame}};
  else if (!result)
    result = compute_turn(scene, out->frames[0], frame, &out->share);
  out->share = within > 0.0 ? fmin(out->share / within, 1.0) : 0.0;
  assert(out->share >= 0.0 && out->frames[0] <= frame && frame <= out->frames[1]);
  return result;
}
