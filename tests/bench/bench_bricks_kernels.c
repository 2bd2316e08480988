/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled once per instruction-set level. */
#include "bench_bricks_kernels.h"

double NP_KERNEL(bench_sample)(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count,
                               double *out_lookups) {
  double sum = 0;
  for (int n = 0; n < ray_count; n++)
    for (int step = 0; step < step_count; step++) {
      double t = (step + 0.5) / step_count;
      sum += (double)np_bricks_sample(bricks, np_dvec3_add(rays[n].origin, np_dvec3_scale(rays[n].direction, t)));
    }
  *out_lookups = (double)ray_count * step_count;
  return sum;
}

static double sum_span(const np_brick_walk *walk, const np_brick_span *span, double spacing, double *lookups) {
  double sum = 0, step = ceil(span->t_begin / spacing - 0.5);
  for (double t = (step + 0.5) * spacing; t < span->t_end; t += spacing, *lookups += 1)
    sum += (double)np_brick_sample(walk->bricks, span->brick, np_brick_walk_local(walk, span, t));
  return sum;
}

/* The same places but for their rounding, NP_BRICK_LINE at a time. */
static double sum_span_by_lines(const np_brick_walk *walk, const np_brick_span *span, double spacing, double *lookups) {
  const double first = (ceil(span->t_begin / spacing - 0.5) + 0.5) * spacing;
  const int count = (int)fmax(0.0, ceil((span->t_end - first) / spacing));
  const np_vec3 begin = np_brick_walk_local(walk, span, first);
  const np_vec3 step = np_vec3_subtract(np_brick_walk_local(walk, span, first + spacing), begin);
  double sum = 0;
  for (int k = 0; k < count; k += NP_BRICK_LINE) {
    float out[NP_BRICK_LINE];
    const int some = count - k < NP_BRICK_LINE ? count - k : NP_BRICK_LINE;
    np_brick_sample_line(walk->bricks, span->brick, span->cell, np_vec3_add(begin, np_vec3_scale(step, (float)k)), step,
                         some, out);
    for (int i = 0; i < some; i++) sum += (double)out[i];
  }
  *lookups += count;
  return sum;
}

typedef double (*sum_fn)(const np_brick_walk *walk, const np_brick_span *span, double spacing, double *lookups);

static inline double sum_rays(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count, sum_fn sum,
                              double *out_lookups) {
  double total = 0;
  *out_lookups = 0;
  for (int n = 0; n < ray_count; n++) {
    np_brick_walk walk;
    np_brick_span span;
    np_brick_walk_start(&walk, bricks, rays[n].origin, rays[n].direction, 0.0, 1.0);
    while (np_brick_walk_next(&walk, &span))
      if (span.brick != NP_BRICK_NONE) total += sum(&walk, &span, 1.0 / step_count, out_lookups);
  }
  return total;
}

double NP_KERNEL(bench_walk)(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count,
                             double *out_lookups) {
  return sum_rays(bricks, rays, ray_count, step_count, sum_span, out_lookups);
}

double NP_KERNEL(bench_lines)(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count,
                              double *out_lookups) {
  return sum_rays(bricks, rays, ray_count, step_count, sum_span_by_lines, out_lookups);
}
