/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/pilot_points.h"

#include "core/alloc.h"
#include "frame/disk_boxes.h"

/* Constant that separates the pilots' seed from the frame's and from the error probes'. */
static const uint64_t turn = UINT64_C(0xbb67ae8584caa73b);

/* Steps of the R2 sequence, by the plastic number. */
static const double step[2] = {0.7548776662466927, 0.5698402909980532};

/* ---- Places ---- */

enum { BOX_POINTS = 64 };

static double count_pixels(const np_pixel_box *b) { return (double)(b->max[0] - b->min[0]) * (b->max[1] - b->min[1]); }

static np_pixel_box get_view(const np_frame *f) {
  return (np_pixel_box){{f->view_min[0], f->view_min[1]}, {f->view_max[0], f->view_max[1]}};
}

static unsigned count_box_points(const np_pixel_box *b) { return (unsigned)fmin(count_pixels(b), BOX_POINTS); }

/* Chooses points in a box: every pixel of a small box, else a low-discrepancy set. */
static void place_in_box(const np_pixel_box *b, double pixels, np_pilot_point *points) {
  const unsigned count = count_box_points(b);
  const int width = b->max[0] - b->min[0];
  for (unsigned i = 0; i < count; i++) {
    const int n = (int)((uint64_t)i * (uint64_t)count_pixels(b) / count);
    points[i].at[0] = b->min[0] + n % width;
    points[i].at[1] = b->min[1] + n / width;
    points[i].share = count_pixels(b) / pixels / count;
  }
}

/* Chooses low-discrepancy points over the view, shifted by seed and frame. Points inside a box get no share, as the box
 * has its own. */
static void place_in_view(const np_frame *f, const np_pixel_box *boxes, unsigned box_count, unsigned count,
                          np_pilot_point *points) {
  np_random random = np_random_start(f->desc->seed ^ turn, (uint32_t)f->desc->frame, 0, 0, 0);
  const double offset[2] = {np_random_double(&random), np_random_double(&random)};
  const np_pixel_box view = get_view(f);
  double left = 1.0, outside = 0.0;
  for (unsigned b = 0; b < box_count; b++) left -= count_pixels(&boxes[b]) / count_pixels(&view);
  for (unsigned i = 0; i < count; i++) {
    np_pilot_point *p = &points[i];
    for (int a = 0; a < 2; a++) {
      const double x = offset[a] + step[a] * i;
      p->at[a] = view.min[a] + (int)((x - floor(x)) * (view.max[a] - view.min[a]));
    }
    p->share = 1.0;
    for (unsigned b = 0; b < box_count; b++)
      if (np_pixel_box_has(&boxes[b], p->at)) p->share = 0.0;
    outside += p->share;
  }
  for (unsigned i = 0; i < count; i++) points[i].share *= fmax(left, 0.0) / fmax(outside, 1.0);
}

static neph_result place(const np_frame *f, unsigned count, np_pilot_points *out) {
  np_pixel_box boxes[NP_LIGHTS_MAX];
  const unsigned box_count = np_frame_get_disks(f, boxes);
  const np_pixel_box view = get_view(f);
  out->count = count;
  for (unsigned b = 0; b < box_count; b++) out->count += count_box_points(&boxes[b]);
  out->at = np_alloc(f->assembly->context, out->count, sizeof *out->at);
  if (!out->at) return NEPH_ERROR_OUT_OF_MEMORY;
  place_in_view(f, boxes, box_count, count, out->at);
  for (unsigned b = 0, next = count; b < box_count; next += count_box_points(&boxes[b++]))
    place_in_box(&boxes[b], count_pixels(&view), out->at + next);
  return NEPH_OK;
}

/* ---- Samples ---- */

typedef struct pilot_job {
  const np_frame *frame; /* a copy with another seed */
  const np_pilot_order *order;
  np_pilot_point *points;
} pilot_job;

/* Number of seeds. The spread of a pixel's stratified samples underestimates the noise; the variance over seeds does
 * not. */
enum { SEEDS = 2 };

/* Samples a pilot's middle pixel with two seeds. `variance` first holds the means of the first seed, then the variances
 * between both. */
static neph_result sample_levels(const pilot_job *job, np_pilot_point *p) {
  np_pixel_state state = {.next = 0};
  double numbers[NP_PIXEL_NUMBERS_MAX], value = 0.0;
  for (unsigned level = 0; level < job->order->levels; level++) {
    neph_result result = np_frame_sample_pixel(job->frame, p->at, 1u << level, &state, numbers);
    if (result) return result;
    value = (double)np_frame_get_pilot(job->frame, numbers, state.next).mean;
    p->variance[level] = value - p->variance[level];
  }
  p->mean += value / SEEDS;
  return NEPH_OK;
}

static neph_result sample_traced(const pilot_job *job, np_pilot_point *p) {
  np_pilot pilot;
  neph_result result = np_frame_fly_pilot(job->frame, p->at, 1u << (job->order->levels - 1), &pilot);
  if (result) return result;
  p->mean = (double)pilot.mean;
  p->variance[0] = (double)pilot.squares / fmax((double)pilot.count - 1.0, 1.0);
  return NEPH_OK;
}

static neph_result sample_middles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const pilot_job *job = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++)
    result = job->order->is_traced ? sample_traced(job, &job->points[i]) : sample_levels(job, &job->points[i]);
  return result;
}

static neph_result sample_around(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const pilot_job *job = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++)
    for (int k = 0; k < NP_PILOTS_AROUND && !result; k++) {
      np_pilot_point *p = &job->points[i];
      const int at[2] = {p->at[0] + k % 3 - 1, p->at[1] + k / 3 - 1};
      if (k != NP_PILOT_MIDDLE && np_frame_is_in_view(job->frame, at))
        result = np_frame_fly_pilot(job->frame, at, job->order->first, &p->around[k]);
    }
  return result;
}

/* Samples all pilots. The neighbours of a pilot take one seed more. */
static neph_result sample(const np_frame *f, const np_pilot_order *order, np_pilot_points *points) {
  neph_render_desc desc;
  np_frame *copy = np_frame_copy_for_luminance(f, &desc);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  const uint64_t own = desc.seed;
  const unsigned seeds = order->is_traced ? 1 : SEEDS;
  pilot_job job = {copy, order, points->at};
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k <= seeds && !result; k++) {
    desc.seed = own ^ np_random_mix(turn + 1 + k);
    if (k < seeds)
      result = np_parallel_for(f->assembly->context, f->monitor, points->count, 1, sample_middles, &job);
    else if (order->first)
      result = np_parallel_for(f->assembly->context, f->monitor, points->count, 1, sample_around, &job);
  }
  np_alloc_free(f->assembly->context, copy);
  return result;
}

/* ---- Means and variances ---- */

/* Few noisy samples that are too bright together are noisy together: over the square of their own mean their variance
 * is never large. */
static double average_around(const np_pilot_point *p) {
  double sum = 0.0, count = 0.0;
  for (int k = 0; k < NP_PILOTS_AROUND; k++) {
    sum += (double)p->around[k].count * (double)p->around[k].mean;
    count += (double)p->around[k].count;
  }
  return count > 0.0 ? sum / count : p->mean;
}

static void finish(const np_pilot_order *order, np_pilot_points *points) {
  double sum = 0.0;
  for (unsigned i = 0; i < points->count; i++) {
    np_pilot_point *p = &points->at[i];
    sum += p->share * p->mean;
    for (unsigned level = 0; level < points->levels && !order->is_traced; level++)
      p->variance[level] *= p->variance[level] / SEEDS;
    if (order->is_traced) p->mean = average_around(p);
  }
  points->dim = fmax(0.01 * sum, 0.0);
}

neph_result np_pilot_points_fly(const np_frame *f, const np_pilot_order *order, np_pilot_points *out) {
  const uint64_t middle = (uint64_t)1 << (order->levels - 1), around = (uint64_t)(NP_PILOTS_AROUND - 1) * order->first;
  *out = (np_pilot_points){.levels = order->is_traced ? 1 : order->levels};
  neph_result result = place(f, order->count, out);
  out->sample_count = out->count * (around + (order->is_traced ? middle : SEEDS * middle));
  if (!result) result = sample(f, order, out);
  if (!result) finish(order, out);
  if (result) np_pilot_points_clear(f, out);
  return result;
}

void np_pilot_points_clear(const np_frame *f, np_pilot_points *points) {
  np_alloc_free(f->assembly->context, points->at);
  points->at = NULL;
}
