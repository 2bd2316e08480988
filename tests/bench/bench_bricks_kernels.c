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

double NP_KERNEL(bench_walk)(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count,
                             double *out_lookups) {
  double sum = 0;
  *out_lookups = 0;
  for (int n = 0; n < ray_count; n++) {
    np_brick_walk walk;
    np_brick_span span;
    np_brick_walk_start(&walk, bricks, rays[n].origin, rays[n].direction, 0.0, 1.0);
    while (np_brick_walk_next(&walk, &span))
      if (span.brick != NP_BRICK_NONE) sum += sum_span(&walk, &span, 1.0 / step_count, out_lookups);
  }
  return sum;
}
