/* SPDX-License-Identifier: Apache-2.0 */
/* Lines along x, y and z in turn. On each, the transform of a sampled function f is the lower envelope of the parabolas
 * f(q) + (x − q)². A value's sign says on which side its sample is, and the function of the other side is 0 there: one
 * array holds both. */
#include "export/distance_transform.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/math.h"

enum { LINES = 16 }; /* lines of a bundle, side by side in memory */

/* Scratch of a thread. */
typedef struct scratch {
  float *bundle;    /* a bundle of LINES contiguous lines */
  float *function;  /* squared distances before */
  float *transform; /* after */
  int *vertices;    /* parabolas of the envelope */
  double *begins;   /* where each begins */
} scratch;

typedef struct transform_job {
  const unsigned *size;
  float *values;
  int axis;
  double edge_m;
  size_t stride;    /* values between samples of a line */
  scratch *scratch; /* one of each thread */
} transform_job;

/* Transform of `function` along a line. */
static void transform_line(const scratch *s, int count, double edge_m) {
  const double edge2 = edge_m * edge_m;
  int last = -1;
  for (int q = 0; q < count; q++) {
    if (s->function[q] >= NP_DISTANCE_NONE) continue;
    const double f = (double)s->function[q] / edge2 + (double)q * q;
    double begin = -HUGE_VAL;
    while (last >= 0) {
      const int v = s->vertices[last];
      begin = (f - ((double)s->function[v] / edge2 + (double)v * v)) / (2.0 * (q - v));
      if (begin > s->begins[last]) break;
      last--;
    }
    last++;
    s->vertices[last] = q;
    s->begins[last] = last ? begin : -HUGE_VAL;
  }
  for (int x = 0, k = 0; x < count; x++) {
    while (k < last && s->begins[k + 1] < (double)x) k++;
    const double d = last >= 0 ? x - s->vertices[k] : 0.0;
    s->transform[x] = last >= 0 ? (float)(d * d * edge2 + (double)s->function[s->vertices[k]]) : NP_DISTANCE_NONE;
  }
}

/* Transforms both sides of a line. */
static void transform_sides(const scratch *s, float *line, int count, double edge_m) {
  for (int side = 0; side < 2; side++) {
    const float sign = side ? -1.0f : 1.0f;
    for (int i = 0; i < count; i++) s->function[i] = np_maxf(sign * line[i], 0.0f);
    transform_line(s, count, edge_m);
    for (int i = 0; i < count; i++)
      if (sign * line[i] > 0.0f) line[i] = sign * s->transform[i];
  }
}

/* First value of a line: lines are numbered by the other two axes, the lower one fastest. */
static size_t locate_line(const transform_job *job, size_t line) {
  const size_t nx = job->size[0], ny = job->size[1];
  assert(job->axis >= 0 && job->axis < 3);
  if (job->axis == 0) return line * nx;
  if (job->axis == 1) return line / nx * nx * ny + line % nx;
  return line;
}

static neph_result transform_bundles(void *user, size_t begin, size_t end, unsigned thread) {
  const transform_job *job = user;
  const scratch *s = &job->scratch[thread];
  const size_t count = job->size[job->axis];
  const size_t lines = (size_t)job->size[0] * job->size[1] * job->size[2] / count;
  for (size_t b = begin; b < end; b++) {
    const size_t first = b * LINES, bundled = lines - first < LINES ? lines - first : LINES;
    size_t at[LINES];
    for (size_t l = 0; l < bundled; l++) at[l] = locate_line(job, first + l);
    for (size_t i = 0; i < count; i++)
      for (size_t l = 0; l < bundled; l++) s->bundle[l * count + i] = job->values[at[l] + i * job->stride];
    for (size_t l = 0; l < bundled; l++) transform_sides(s, s->bundle + l * count, (int)count, job->edge_m);
    for (size_t i = 0; i < count; i++)
      for (size_t l = 0; l < bundled; l++) job->values[at[l] + i * job->stride] = s->bundle[l * count + i];
  }
  return NEPH_OK;
}

static neph_result allocate(neph_context *context, size_t longest, scratch *s) {
  s->bundle = np_alloc(context, LINES * longest, sizeof *s->bundle);
  s->function = np_alloc(context, longest, sizeof *s->function);
  s->transform = np_alloc(context, longest, sizeof *s->transform);
  s->vertices = np_alloc(context, longest, sizeof *s->vertices);
  s->begins = np_alloc(context, longest, sizeof *s->begins);
  return s->bundle && s->function && s->transform && s->vertices && s->begins ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void release(neph_context *context, scratch *s) {
  np_alloc_free(context, s->bundle);
  np_alloc_free(context, s->function);
  np_alloc_free(context, s->transform);
  np_alloc_free(context, s->vertices);
  np_alloc_free(context, s->begins);
}

static neph_result transform_axes(neph_context *context, np_monitor *monitor, const double edge_m[3],
                                  transform_job *job) {
  neph_result result = NEPH_OK;
  job->stride = 1;
  for (int a = 0; a < 3 && !result; a++) {
    const size_t lines = (size_t)job->size[0] * job->size[1] * job->size[2] / job->size[a];
    job->axis = a;
    job->edge_m = edge_m[a];
    np_monitor_set_range(monitor, a / 3.0, (a + 1) / 3.0);
    result = np_parallel_for(context, monitor, (lines + LINES - 1) / LINES, 1, transform_bundles, job);
    job->stride *= job->size[a];
  }
  return result;
}

neph_result np_distance_transform(neph_context *context, np_monitor *monitor, const unsigned size[3],
                                  const double edge_m[3], float *values) {
  const unsigned threads = context->thread_count;
  size_t longest = 0;
  for (int a = 0; a < 3; a++) longest = size[a] > longest ? size[a] : longest;
  transform_job job = {.size = size, .values = values};
  job.scratch = np_alloc(context, threads, sizeof *job.scratch);
  neph_result result = job.scratch ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned t = 0; t < threads && !result; t++) result = allocate(context, longest, &job.scratch[t]);
  if (!result) result = transform_axes(context, monitor, edge_m, &job);
  for (unsigned t = 0; t < threads && job.scratch; t++) release(context, &job.scratch[t]);
  np_alloc_free(context, job.scratch);
  return result;
}
