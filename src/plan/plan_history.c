/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan_history.h"

#include <math.h>
#include <string.h>

#include "core/text.h"
#include "plan/part_check.h"
#include "plan/stage_decisions.h"
#include "scene/sequence.h"

bool np_plan_is_reconstructed(const neph_scene *scene) {
  return scene->render.upsample > 1 || np_scene_has_history(scene);
}

double np_plan_get_rendered_share(const neph_scene *scene) {
  const double frames = scene->render.history_frames, resolution = 1.0 / pow(scene->render.upsample, 2.0);
  if (!np_scene_has_history(scene)) return resolution;
  return resolution * (1.0 + (frames - 1.0) / scene->render.history_update) / frames;
}

/* ---- Pictures that are refused ---- */

/* Channels that are no means of samples, or not of this frame's samples alone. */
static const unsigned refused_aovs =
    NP_AOV_STANDARD_ERROR | NP_AOV_VARIANCE | NP_AOV_SAMPLE_COUNT | NP_AOV_MEAN_DISTANCE | NP_AOV_CRYPTOMATTE;

static const char *search_aov(unsigned aovs) {
  for (unsigned i = 0; i < NP_AOV_COUNT; i++)
    if (aovs & refused_aovs & 1u << i) return np_aov_rows[i].name;
  return NULL;
}

static bool is_whole(const neph_render_desc *d) {
  return d->crop_min[0] == 0 && d->crop_min[1] == 0 && d->crop_max[0] == d->width && d->crop_max[1] == d->height &&
         d->tile_count == 1;
}

/* An option or key that excludes history, with the remedy; NULL: none. */
static const char *search_conflict(const neph_scene *scene, const neph_render_desc *d) {
  const struct {
    bool is_given;
    const char *text;
  } rows[] = {
      {!is_whole(d), "a crop or a tile, whose pixels would lack their neighbours: render the whole picture"},
      {np_part_is_range(d), "a range of samples: render all samples"},
      {d->part_path || d->checkpoint_path, "a part or a checkpoint: leave it out"},
      {scene->output.deep, "deep pixels: leave out output.deep"},
      {isfinite(d->target_error), "a target error, which needs the samples of all pixels: leave it out"},
      {isfinite(d->time_limit_s), "a time limit, whose samples nobody can repeat: leave it out"},
  };
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
    if (rows[i].is_given) return rows[i].text;
  return NULL;
}

neph_result np_plan_check_history(const neph_scene *scene, const np_request *request) {
  if (!np_plan_is_reconstructed(scene)) return NEPH_OK;
  const bool has_history = np_scene_has_history(scene);
  const char *key = has_history ? "render.history" : "render.upsample", *off = has_history ? "none" : "1";
  const char *conflict = search_conflict(scene, &request->desc), *aov = search_aov(request->aovs);
  if (conflict)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "%s does not go with %s, or set %s to %s", key,
                   conflict, key, off);
  if (aov)
    return np_fail(scene->context, NEPH_ERROR_BAD_SCENE,
                   "%s does not go with the %s of output.aovs, which pixels that are not rendered do not have: leave "
                   "it out, or set %s to %s",
                   key, aov, key, off);
  return NEPH_OK;
}

/* ---- The stage ---- */

void np_stage_decide_history(np_decision *d, np_stage_decision *out) {
  const np_scene_render *render = &d->scene->render;
  const int frame = d->plan->request.desc.frame, first = np_scene_get_history_first(d->scene, frame);
  const bool is_needed = np_scene_has_history(d->scene);
  if (render->history == NP_HISTORY_NONE)
    np_stage_decide(d, out, is_needed, "render.history is none");
  else if (!is_needed)
    np_stage_decide(d, out, is_needed, "one frame: nothing in the scene changes from frame to frame");
  else if (frame == first)
    np_stage_decide(d, out, is_needed, "frame %d begins a block of %u: it is rendered by itself, for the next", frame,
                    render->history_frames);
  else
    np_stage_decide(
        d, out, is_needed,
        "1 pixel in %u is rendered, the others are those of frame %d; a process without it renders from frame %d "
        "on",
        render->history_update, frame - 1, first);
}

static double predict_frame_bytes(const np_request *request) {
  const double channels = (double)request->film_bytes / sizeof(float);
  return channels * sizeof(float) + (double)np_request_count_pixels(request) * (sizeof(float) + NP_HISTORY_GUIDE_BYTES);
}

double np_plan_predict_reconstruction_bytes(const neph_scene *scene, const np_request *request) {
  return np_plan_is_reconstructed(scene) ? predict_frame_bytes(request) + (double)np_request_count_pixels(request)
                                         : 0.0;
}

void np_stage_count_history(const np_plan *plan, const neph_scene *scene, np_cost_counts *out) {
  const double places = (double)np_request_count_pixels(&plan->request) * NP_HISTORY_PLACE_BYTES;
  const double changes = np_scene_has_still_light(scene) ? 0.0 : (double)plan->request.film_bytes;
  out->of[NP_UNIT_BYTE] = predict_frame_bytes(&plan->request) + places + changes;
}
