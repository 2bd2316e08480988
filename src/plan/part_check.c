/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/part_check.h"

#include "image/film.h"

static neph_result check_samples(neph_context *context, const neph_render_desc *d) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (d->sample_end > d->sample_count)
    return np_fail(context, bad, "the range of samples ends at %u, must end at %u at most, the picture's samples",
                   d->sample_end, d->sample_count);
  if (!np_part_is_range(d)) return NEPH_OK;
  if (d->sample_begin >= d->sample_end || d->sample_begin % NP_FILM_LEAF_SAMPLES)
    return np_fail(context, bad,
                   "the range of samples is %u to %u of %u, must begin at a multiple of %d and end behind that",
                   d->sample_begin, d->sample_end, d->sample_count, (int)NP_FILM_LEAF_SAMPLES);
  if (d->sample_end % NP_FILM_LEAF_SAMPLES && d->sample_end < d->sample_count)
    return np_fail(context, bad,
                   "the range of samples ends at %u, must end at a multiple of %d, or with the picture's last, %u",
                   d->sample_end, (int)NP_FILM_LEAF_SAMPLES, d->sample_count);
  if (isfinite(d->target_error))
    return np_fail(context, bad,
                   "a range of samples cannot be rendered with a target error, which chooses them by pixel: split the "
                   "picture into tiles, or give it a number of samples");
  return NEPH_OK;
}

neph_result np_part_check(const neph_scene *scene, const np_request *request) {
  const neph_render_desc *d = &request->desc;
  neph_result result = check_samples(scene->context, d);
  if (result || (!d->part_path && !d->checkpoint_path && !np_part_is_range(d))) return result;
  if (isfinite(d->time_limit_s))
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "a part or a checkpoint cannot be kept of a picture with a time limit, whose samples nobody can "
                   "repeat: leave out render.time_limit");
  if (scene->output.deep)
    return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "a part or a checkpoint cannot be kept of deep pixels: leave out output.deep, or split the picture "
                   "into tiles, whose deep files a compositor merges");
  return NEPH_OK;
}

neph_result np_part_check_hash(const np_plan *plan) {
  const neph_render_desc *d = &plan->request.desc;
  if (*plan->hash || (!d->part_path && !d->checkpoint_path)) return NEPH_OK;
  return np_fail(plan->request.context, NEPH_ERROR_INVALID_ARGUMENT,
                 "a part or a checkpoint cannot be kept of a scene with a volume, a terrain or an atmosphere that a "
                 "call gave it, which no file describes: name their files, or render without");
}
