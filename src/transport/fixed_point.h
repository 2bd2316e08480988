/* SPDX-License-Identifier: Apache-2.0 */
/* Fixed points x = g(x) of large vectors, by Anderson acceleration. */
#ifndef NP_TRANSPORT_FIXED_POINT_H
#define NP_TRANSPORT_FIXED_POINT_H

#include "core/parallel.h"

typedef neph_result (*np_fixed_point_fn)(void *user, const float *x, float *out_image);

typedef struct np_fixed_point {
  neph_context *context;
  np_monitor *monitor;
  np_fixed_point_fn map;
  void *user;
  size_t count;     /* floats in x */
  unsigned depth;   /* images that are combined, 1 to NP_FIXED_POINT_DEPTH_MAX; each costs two vectors like x */
  float *vectors;   /* room for them; NULL: allocated */
  double tolerance; /* of ‖g(x) − x‖ / ‖g(x)‖ */
  unsigned calls_max;
  double residual; /* out: reached; 1 when no call was finished */
  unsigned calls;  /* out: of the map */
  bool is_stalled; /* out, for the map too: the residual does not fall any more, and plain iteration goes on */
  bool is_cut;     /* out: the monitor's budget ended it */
} np_fixed_point;

enum { NP_FIXED_POINT_DEPTH_MAX = 20 };

/* Improves `x` until the tolerance is met or the calls are used up; x is then the last image. Same bits for any number
 * of threads. Where the monitor's budget ends before, x is the image of the least residual among the remembered ones,
 * and the budget is left for the caller to end. */
neph_result np_fixed_point_solve(np_fixed_point *problem, float *x);

#endif
