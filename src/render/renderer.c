/* SPDX-License-Identifier: Apache-2.0 */
/* Render jobs: their stores, progress callback and cancel flag. */
#include <nephos/renderer.h>

#include <math.h>

#include "core/alloc.h"
#include "core/given.h"
#include "frame/frame.h"
#include "frame/history.h"
#include "frame/kept_samples.h"
#include "frame/prediction.h"
#include "frame/tile_feed.h"
#include "parts/part_film.h"
#include "plan/effort.h"
#include "plan/light_span.h"
#include "render/render_calls.h"
#include "render/renderer_stores.h"
#include "scene/scene_eval.h"
#include "stages/light_anchors.h"

struct neph_renderer {
  neph_context *context; /* retained */
  np_stores stores;
  np_kept_samples kept;
  bool keeps_samples, has_focus;
  double focus[2];
  atomic_bool is_busy;      /* a picture is being rendered */
  atomic_bool is_cancelled; /* cancels the current picture, or the next one if there is none */
};

/* State of one call that renders a picture. */
typedef struct picture_call {
  np_plan plan; /* owned */
  np_render_job job;
  np_tile_feed feed;
  const atomic_bool *is_cancelled; /* NULL: callbacks alone can end it */
  neph_progress_fn progress;       /* may be NULL */
  void *progress_user;
} picture_call;

/* Progress callback, on the calling thread, many times a second. */
static bool report_progress(void *user, const neph_progress *progress) {
  picture_call *call = user;
  if (call->is_cancelled && atomic_load(call->is_cancelled)) return false;
  if (!np_tile_feed_deliver(&call->feed, progress->elapsed_s)) return false;
  return !call->progress || call->progress(call->progress_user, progress);
}

/* Chooses the frames between which the light is interpolated, and solves for their light. */
static neph_result prepare_light(const neph_scene *scene, const np_plan *plan, np_build_job *job, np_monitor *monitor) {
  neph_result result = np_light_span_choose(scene, plan, &job->light_span);
  if (result || job->light_span.frames[0] == job->light_span.frames[1]) return result;
  const unsigned mode = np_float_mode_enter();
  result = np_light_anchors_solve(scene, plan, job, monitor);
  np_float_mode_leave(mode);
  return result;
}

static neph_result prepare_plan(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  const neph_result result = np_prediction_prepare(scene, plan, store);
  return result ? result : np_plan_fit_memory(scene, plan, store);
}

/* Renders a picture by a prepared plan. With history, the stores have the previous frame. */
static neph_result render_planned(const neph_scene *scene, np_plan *plan, const np_render_job *job, np_monitor *monitor,
                                  neph_image **out_image) {
  np_render_job lit = *job;
  const neph_result result = prepare_light(scene, plan, &lit.build, monitor);
  return result ? result : np_render_image(scene, plan, &lit, monitor, out_image);
}

/* A run-up frame: later frames need its history. */
static neph_result render_before(const neph_scene *scene, const np_plan *plan, int frame, const np_render_job *job,
                                 np_monitor *monitor) {
  neph_scene at;
  np_plan at_frame;
  neph_render_desc desc = plan->request.desc;
  neph_image *image = NULL;
  desc.frame = frame;
  neph_result result = np_plan_make_frame(scene, &desc, &at, &at_frame);
  if (!result) result = prepare_plan(&at, &at_frame, &job->build.stores->inputs);
  if (!result)
    np_log(scene->context, NEPH_LOG_DEBUG, "history: frame %d is rendered for frame %d", frame,
           plan->request.desc.frame);
  if (!result) result = render_planned(&at, &at_frame, job, monitor, &image);
  neph_image_destroy(image);
  np_plan_clear(&at_frame);
  np_scene_eval_clear(&at);
  return result;
}

/* Renders those frames of the plan's block, before its own, that history needs and the stores lack. */
static neph_result prepare_history(const neph_scene *scene, picture_call *call, np_monitor *monitor) {
  const np_plan *plan = &call->plan;
  np_stores *stores = call->job.build.stores;
  const int frame = plan->request.desc.frame;
  int begin = frame;
  neph_result result = np_history_choose_begin(scene, plan, stores, &begin);
  if (result || begin == frame) return result;
  const double count = (double)frame - begin + 1;
  for (int i = begin; i < frame && !result; i++) {
    const np_render_job job = {.build = {.stores = stores, .progress = {(i - begin) / count, (i - begin + 1) / count}}};
    result = render_before(scene, plan, i, &job, monitor);
  }
  call->job.build.progress.begin = (count - 1.0) / count;
  return result;
}

/* A picture of a scene in its frame. */
static neph_result render_picture(const neph_scene *scene, picture_call *call, neph_image **out_image) {
  const neph_render_desc *desc = &call->plan.request.desc;
  call->progress = desc->progress;
  call->progress_user = desc->progress_user;
  call->feed = (np_tile_feed){.fn = desc->tile, .user = desc->tile_user};
  call->job.feed = &call->feed;
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, report_progress, call);
  if (!report_progress(call, &(neph_progress){.stage = "planning", .remaining_s = HUGE_VAL}))
    return NEPH_ERROR_CANCELLED;
  neph_result result = prepare_plan(scene, &call->plan, &call->job.build.stores->inputs);
  if (!result) result = prepare_history(scene, call, &monitor);
  return result ? result : render_planned(scene, &call->plan, &call->job, &monitor, out_image);
}

/* Renders by the stores, and by what else `renderer` has; NULL: nothing. */
static neph_result render_from_stores(const neph_scene *scene, const neph_render_desc *desc, np_stores *stores,
                                      neph_renderer *renderer, neph_image **out_image) {
  const atomic_bool *is_cancelled = renderer ? &renderer->is_cancelled : NULL;
  picture_call call = {.job = {.build = np_build_job_make(stores),
                               .sink = &np_part_film_sink,
                               .kept = renderer && renderer->keeps_samples ? &renderer->kept : NULL,
                               .focus = renderer && renderer->has_focus ? renderer->focus : NULL},
                       .is_cancelled = is_cancelled};
  neph_scene at;
  neph_result result = np_plan_make_frame(scene, desc, &at, &call.plan);
  if (!result) result = render_picture(&at, &call, out_image);
  np_plan_clear(&call.plan);
  np_scene_eval_clear(&at);
  return result;
}

neph_result neph_render_image(const neph_scene *scene, const neph_render_desc *desc, neph_image **out_image) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_image)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_stores stores = {.results = NULL};
  *out_image = NULL;
  const neph_result result = render_from_stores(scene, desc, &stores, NULL, out_image);
  np_stores_clear(scene->context, &stores);
  return result;
}

neph_result neph_renderer_create(neph_context *context, neph_renderer **out_renderer) {
  if (NP_LACKS_OUT(context, out_renderer)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_renderer = np_alloc(context, 1, sizeof **out_renderer);
  if (!*out_renderer) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  (*out_renderer)->context = (*out_renderer)->kept.context = context;
  atomic_init(&(*out_renderer)->is_busy, false);
  atomic_init(&(*out_renderer)->is_cancelled, false);
  return NEPH_OK;
}

void neph_renderer_destroy(neph_renderer *renderer) {
  if (!renderer) return;
  neph_context *context = renderer->context;
  np_stores_clear(context, &renderer->stores);
  np_kept_samples_clear(&renderer->kept);
  np_alloc_free(context, renderer);
  np_context_release(context);
}

void neph_renderer_cancel(neph_renderer *renderer) {
  if (renderer) atomic_store(&renderer->is_cancelled, true);
}

/* Fails where the scene is of another context. */
static neph_result check_scene(const neph_renderer *renderer, const neph_scene *scene) {
  if (scene->context == renderer->context) return NEPH_OK;
  return np_fail(renderer->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the scene belongs to another context than the renderer: make it in the renderer's");
}

/* Reserves the renderer for one call; fails if another thread or a callback is using it. */
static neph_result begin(neph_renderer *renderer) {
  if (!atomic_exchange(&renderer->is_busy, true)) return NEPH_OK;
  return np_fail(renderer->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the renderer has a picture under way, must have one at a time: wait for it, or give each thread a "
                 "renderer of its own");
}

neph_result neph_renderer_render(neph_renderer *renderer, const neph_scene *scene, const neph_render_desc *desc,
                                 neph_image **out_image) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(renderer), out_image, scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = begin(renderer);
  if (result) return result;
  result = check_scene(renderer, scene);
  if (!result && atomic_load(&renderer->is_cancelled)) result = NEPH_ERROR_CANCELLED;
  if (!result) result = render_from_stores(scene, desc, &renderer->stores, renderer, out_image);
  atomic_store(&renderer->is_cancelled, false);
  atomic_store(&renderer->is_busy, false);
  return result;
}

neph_result neph_renderer_keep_samples(neph_renderer *renderer, bool is_kept) {
  if (!renderer) return NEPH_ERROR_INVALID_ARGUMENT;
  const neph_result result = begin(renderer);
  if (result) return result;
  renderer->keeps_samples = is_kept;
  if (!is_kept) np_kept_samples_clear(&renderer->kept);
  atomic_store(&renderer->is_busy, false);
  return NEPH_OK;
}

neph_result neph_renderer_set_focus(neph_renderer *renderer, double x, double y) {
  if (!renderer) return NEPH_ERROR_INVALID_ARGUMENT;
  const neph_result result = begin(renderer);
  if (result) return result;
  renderer->has_focus = isfinite(x) && isfinite(y);
  renderer->focus[0] = x;
  renderer->focus[1] = y;
  atomic_store(&renderer->is_busy, false);
  return NEPH_OK;
}

neph_result np_renderer_borrow(neph_renderer *renderer, const neph_scene *scene, np_stores **out_stores) {
  neph_result result = begin(renderer);
  if (result) return result;
  *out_stores = &renderer->stores;
  result = check_scene(renderer, scene);
  if (result) np_renderer_give_back(renderer);
  return result;
}

void np_renderer_give_back(neph_renderer *renderer) { atomic_store(&renderer->is_busy, false); }

neph_result neph_renderer_explain(neph_renderer *renderer, const neph_scene *scene, const neph_render_desc *desc,
                                  neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(renderer), out_text, scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_stores *stores;
  *out_text = NULL;
  neph_result result = np_renderer_borrow(renderer, scene, &stores);
  if (result) return result;
  result = np_render_explain(scene, desc, stores, format, out_text);
  np_renderer_give_back(renderer);
  return result;
}

neph_result neph_renderer_choose_effort(neph_renderer *renderer, neph_scene *scene, const neph_render_desc *desc,
                                        neph_effort *out_effort) {
  if (NP_LACKS(NP_CONTEXT_OF(renderer), scene, out_effort)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_stores *stores;
  neph_result result = np_renderer_borrow(renderer, scene, &stores);
  if (result) return result;
  result = np_effort_choose(scene, desc, &stores->inputs, out_effort);
  np_renderer_give_back(renderer);
  return result;
}
