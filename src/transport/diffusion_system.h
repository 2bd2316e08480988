/* SPDX-License-Identifier: Apache-2.0 */
/* The diffusion equation on the cells of the multiple scattering: its grids, and their solution. */
#ifndef NP_TRANSPORT_DIFFUSION_SYSTEM_H
#define NP_TRANSPORT_DIFFUSION_SYSTEM_H

#include "core/parallel.h"
#include "transport/transport_grid.h"

enum { NP_DIFFUSION_FACES = 6, NP_DIFFUSION_CHILDREN = 8, NP_DIFFUSION_LEVELS_MAX = 10, NP_DIFFUSION_CHUNK = 8192 };

/* One grid of the V-cycle. Unknowns are numbered by colour, the first `red_count` on cells of even index sums: those of
 * one colour do not touch. Vectors have one more element, 0, which represents vacuum. */
typedef struct np_diffusion_level {
  int32_t count, red_count, size[3];
  int32_t *cell;      /* cell of each unknown, x fastest */
  int32_t *neighbour; /* [unknown][face], down and up each axis; `count`: vacuum */
  int32_t *child;     /* [unknown][child] in the finer level; its `count`: none */
  float *link;        /* [unknown][face] */
  float *inverse;     /* inverse of the diagonal */
  float *x, *right;   /* vectors */
  bool is_coloured;   /* false where an odd period lets cells of one colour touch */
} np_diffusion_level;

typedef struct np_diffusion {
  const np_transport_grid *grid;
  unsigned level_count, smoothings;
  np_diffusion_level levels[NP_DIFFUSION_LEVELS_MAX]; /* the finest first */
  int32_t *active;                                    /* active cell of each unknown of the finest level */
  float *correction, *residual, *step, *image;        /* vectors of the finest level */
  double *sums;                                       /* sum of each chunk */
} np_diffusion;

/* Links the cells with extinction on all levels; `out` is empty if there are none. On failure nothing needs to be
 * freed. */
neph_result np_diffusion_init(const np_transport_grid *grid, np_diffusion *out);
void np_diffusion_clear(np_diffusion *d);

/* Solves for `correction`, to a tenth, with the right side in `residual`. */
void np_diffusion_solve(np_diffusion *d);

/* Arguments of a parallel loop over the unknowns of a level, from `first` on. */
typedef struct np_diffusion_loop {
  np_diffusion *diffusion;
  np_diffusion_level *level, *finer;
  size_t first;
  const float *x;
  float *image;
  const float *a, *b;
  float *out;
  float factor;
} np_diffusion_loop;

/* Runs [first, end) on all threads, unless it is too short to be worth it. */
void np_diffusion_run(np_diffusion_loop *loop, size_t first, size_t end, np_parallel_fn body);

#endif
