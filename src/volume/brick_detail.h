/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks with procedural detail finer than their samples. They share the samples of the source; look-ups add a noise at
 * the edges of the cloud, and the ranges of cells bound the sum (brick_detail_sample.h).
 *
 * The noise is a texture of Worley cells, looked up four times under four rotations. A value is compared with c: 0.7
 * of the largest sample within 4 voxels, interpolated from nodes 4 voxels apart. Bricks that share a face have the same
 * c on it, so that v′ is as continuous as v. In cores, where v ≥ c, values do not change. */
#ifndef NP_VOLUME_BRICK_DETAIL_H
#define NP_VOLUME_BRICK_DETAIL_H

#include "core/parallel.h"
#include "volume/bricks.h"

typedef struct np_brick_detail_desc {
  const np_bricks *source; /* borrowed; at rest, without detail */
  float strength;          /* 0 to 1 */
  double size_voxels[3];   /* size of the largest billows along each axis, above 0 */
  uint64_t seed;
} np_brick_detail_desc;

typedef struct np_detailed_bricks {
  np_bricks bricks; /* result: borrows all but its nodes from the source */
  np_bricks noise;  /* texture of the noise: samples alone */
  np_brick_detail detail;
  float *cores;
} np_detailed_bricks;

/* Builds in parallel, with the same bits for any number of threads. On failure nothing is left. */
neph_result np_detailed_bricks_build(neph_context *context, const np_brick_detail_desc *desc, np_monitor *monitor,
                                     np_detailed_bricks **out);
void np_detailed_bricks_destroy(np_detailed_bricks *detailed);

#endif
