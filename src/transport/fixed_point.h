/* SPDX-License-Identifier: Apache-2.0 */
/* Fixed points x = g(x) of large vectors, by Anderson acceleration. */
#ifndef NP_TRANSPORT_FIXED_POINT_H
#define NP_TRANSPORT_FIXED_POINT_H

#include "core/parallel.h"

/* Maps x; `scratch` takes as many floats as x until the call returns. */
typedef neph_result (*np_fixed_point_fn)(void *user, const float *x, float *scratch, float *out_image);

enum { NP_FIXED_POINT_DEPTH_MAX = 20 };

/* All that the next call depends on, but for x. */
typedef struct np_fixed_point_history {
  unsigned depth; /* slots */
  unsigned count; /* filled, the newest last */
  float *image[NP_FIXED_POINT_DEPTH_MAX], *residual[NP_FIXED_POINT_DEPTH_MAX];
  double gram[NP_FIXED_POINT_DEPTH_MAX][NP_FIXED_POINT_DEPTH_MAX]; /* scalar products of the residuals */
  double relative[NP_FIXED_POINT_DEPTH_MAX]; /* norms of the residuals, relative to the norms of the images */
  double first, before, best;                /* residuals of the first call and of the last one, and the least */
  unsigned idle;                             /* calls since the least has fallen */
} np_fixed_point_history;

struct np_fixed_point;

/* Functions that store an unfinished iteration between two calls of the map. */
typedef struct np_fixed_point_keeper {
  void *user;

  /* Restores a stored history, and `calls`, `residual` and `is_stalled`; false: there is none. */
  bool (*load)(void *user, struct np_fixed_point *problem, np_fixed_point_history *history);

  /* May store the history and x. `is_last`: the iteration was cancelled and ends here. */
  void (*save)(void *user, const struct np_fixed_point *problem, const np_fixed_point_history *history, bool is_last);
} np_fixed_point_keeper;

typedef struct np_fixed_point {
  neph_context *context;
  np_monitor *monitor;
  np_fixed_point_fn map;
  void *user;
  size_t count;     /* floats in x */
  unsigned depth;   /* images that are combined, 1 to NP_FIXED_POINT_DEPTH_MAX; each costs two vectors like x */
  float *vectors;   /* memory for these vectors; NULL: allocated */
  double tolerance; /* bound of ‖g(x) − x‖ / ‖g(x)‖ */
  unsigned calls_max;
  double residual;                     /* out: reached; 1 when no call was finished */
  unsigned calls;                      /* out: of the map */
  bool is_stalled;                     /* out, for the map too: the residual no longer falls; plain iteration follows */
  bool is_cut;                         /* out: the monitor's budget ended it */
  const np_fixed_point_keeper *keeper; /* NULL: none */
} np_fixed_point;

/* Improves `x` until the tolerance is met or the calls are used up; x is then the last image. Same bits for any number
 * of threads. Where the monitor's budget ends before, x is the image of the least residual among the remembered ones,
 * and the budget is left for the caller to end. */
neph_result np_fixed_point_solve(np_fixed_point *problem, float *x);

#endif
