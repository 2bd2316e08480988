/* SPDX-License-Identifier: Apache-2.0 */
/* Interpolation between key frames. The smooth one is the monotone cubic of Steffen (1990, "A simple method for
 * monotonic interpolation in one dimension", Astron. Astrophys. 239, eq. 11): values stay between the two keys. Its
 * slope is 0 at both ends of the track, which continues smoothly as a constant. */
#include "scene/track.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"

/* The interval between the keys `at` and `at` + 1. */
typedef struct interval {
  const np_track *track;
  unsigned index, at;
  double share; /* position in the interval, in [0, 1) */
} interval;

static double get_value(const np_track *t, unsigned index, unsigned at) {
  return t->values[at * t->value_count + index];
}

/* Slope per frame from the key `at` to the next. */
static double get_slope(const np_track *t, unsigned index, unsigned at) {
  assert(at + 1 < t->key_count && t->frames[at] < t->frames[at + 1]);
  return (get_value(t, index, at + 1) - get_value(t, index, at)) / (t->frames[at + 1] - t->frames[at]);
}

static double get_tangent(const np_track *t, unsigned index, unsigned at) {
  if (at == 0 || at + 1 == t->key_count) return 0.0;
  const double before = t->frames[at] - t->frames[at - 1], after = t->frames[at + 1] - t->frames[at];
  const double left = get_slope(t, index, at - 1), right = get_slope(t, index, at);
  const double parabola = (left * after + right * before) / (before + after);
  if (left * right <= 0.0) return 0.0;
  return copysign(fmin(fmin(2.0 * fabs(left), 2.0 * fabs(right)), fabs(parabola)), left);
}

static double eval_step(const interval *i) { return get_value(i->track, i->index, i->at); }

static double eval_linear(const interval *i) {
  const double a = get_value(i->track, i->index, i->at), b = get_value(i->track, i->index, i->at + 1);
  return a + i->share * (b - a);
}

static double eval_smooth(const interval *i) {
  const np_track *t = i->track;
  const double a = get_value(t, i->index, i->at), b = get_value(t, i->index, i->at + 1), s = i->share;
  const double width = t->frames[i->at + 1] - t->frames[i->at];
  const double from = width * get_tangent(t, i->index, i->at), to = width * get_tangent(t, i->index, i->at + 1);
  return a + s * (from + s * (3.0 * (b - a) - 2.0 * from - to + s * (from + to - 2.0 * (b - a))));
}

static const struct {
  const char *name;
  double (*eval)(const interval *i);
} rows[NP_INTERPOLATION_COUNT] = {
    [NP_INTERPOLATION_STEP] = {"step", eval_step},
    [NP_INTERPOLATION_LINEAR] = {"linear", eval_linear},
    [NP_INTERPOLATION_SMOOTH] = {"smooth", eval_smooth},
};

const char *np_interpolation_get_name(np_interpolation interpolation) { return rows[interpolation].name; }

bool np_interpolation_get(const char *name, np_interpolation *out) {
  for (int i = 0; i < NP_INTERPOLATION_COUNT; i++)
    if (!strcmp(rows[i].name, name)) return *out = (np_interpolation)i, true;
  return false;
}

double np_track_eval(const np_track *track, unsigned index, double frame) {
  unsigned low = 0, high = track->key_count - 1;
  assert(track->key_count >= 1 && index < track->value_count);
  if (frame <= track->frames[0]) return get_value(track, index, 0);
  if (frame >= track->frames[high]) return get_value(track, index, high);
  while (high - low > 1) {
    const unsigned middle = (low + high) / 2;
    *(track->frames[middle] <= frame ? &low : &high) = middle;
  }
  const double share = (frame - track->frames[low]) / (track->frames[low + 1] - track->frames[low]);
  return rows[track->interpolation].eval(&(interval){track, index, low, share});
}

neph_result np_track_alloc(neph_context *context, np_track *track, unsigned key_count) {
  track->key_count = key_count;
  track->frames = np_alloc(context, key_count, sizeof *track->frames);
  track->values = np_alloc(context, (size_t)key_count * track->value_count, sizeof *track->values);
  return track->frames && track->values ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_track_clear(neph_context *context, np_track *track) {
  np_alloc_free(context, track->frames);
  np_alloc_free(context, track->values);
  track->frames = track->values = NULL;
}
