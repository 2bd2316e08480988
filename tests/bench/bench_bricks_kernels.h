/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_BENCH_BRICKS_KERNELS_H
#define NP_BENCH_BRICKS_KERNELS_H

#include "core/isa.h"
#include "volume/brick_walk.h"

typedef struct bench_ray {
  np_dvec3 origin, direction; /* index position = origin + t·direction, t from 0 to 1 */
} bench_ray;

/* Sum of the values of `step_count` look-ups along each ray: by np_bricks_sample, and by a walk that looks up only
 * inside bricks, one position at a time or in lines. `out_lookups` receives the number of look-ups. */
typedef double (*bench_kernel)(const np_bricks *bricks, const bench_ray *rays, int ray_count, int step_count,
                               double *out_lookups);

typedef struct bench_kernels {
  bench_kernel sample, walk, lines;
} bench_kernels;

double bench_sample_v1(const np_bricks *, const bench_ray *, int, int, double *);
double bench_sample_v3(const np_bricks *, const bench_ray *, int, int, double *);
double bench_sample_v4(const np_bricks *, const bench_ray *, int, int, double *);
double bench_walk_v1(const np_bricks *, const bench_ray *, int, int, double *);
double bench_walk_v3(const np_bricks *, const bench_ray *, int, int, double *);
double bench_walk_v4(const np_bricks *, const bench_ray *, int, int, double *);
double bench_lines_v1(const np_bricks *, const bench_ray *, int, int, double *);
double bench_lines_v3(const np_bricks *, const bench_ray *, int, int, double *);
double bench_lines_v4(const np_bricks *, const bench_ray *, int, int, double *);

#endif
