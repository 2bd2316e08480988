/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks with detail that their samples do not hold: bricks of the same samples, whose look-ups go through a noise
 * where the grid has an edge, and whose ranges are those of what is then found (brick_detail_sample.h).
 *
 * The noise is a texture of Worley cells, looked up three times in three turns. What a value is compared with, c, is
 * 0.7 of the largest sample within 4 voxels, interpolated from nodes 4 voxels apart: the same on both sides of each
 * face between bricks, so that v′ is as continuous as v. Where v ≥ c, in cores, nothing is changed. */
#ifndef NP_VOLUME_BRICK_DETAIL_H
#define NP_VOLUME_BRICK_DETAIL_H

#include "core/parallel.h"
#include "volume/bricks.h"

typedef struct np_brick_detail_desc {
  const np_bricks *source; /* borrowed; at rest, without detail */
  float strength;          /* 0 to 1 */
  double size_voxels[3];   /* of its largest billows along each axis, above 0 */
  uint64_t seed;
} np_brick_detail_desc;

typedef struct np_detailed_bricks {
  np_bricks bricks; /* borrows all but its nodes from the source */
  np_bricks noise;  /* samples alone */
  np_brick_detail detail;
  float *cores;
} np_detailed_bricks;

/* In parallel, the same bits for any number of threads. On failure nothing is left. */
neph_result np_detailed_bricks_build(neph_context *context, const np_brick_detail_desc *desc, np_monitor *monitor,
                                     np_detailed_bricks **out);
void np_detailed_bricks_destroy(np_detailed_bricks *detailed);

#endif
