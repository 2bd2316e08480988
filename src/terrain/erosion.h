/* SPDX-License-Identifier: Apache-2.0 */
/* Rivers that cut rising ground into ridges and valleys. */
#ifndef NP_TERRAIN_EROSION_H
#define NP_TERRAIN_EROSION_H

#include "core/parallel.h"

/* A square of ground with height 0 along its border. Lengths and heights share one unit; in the unit of time the
 * erodibility is 1. */
typedef struct np_erosion {
  unsigned side; /* samples, ≥ 2 */
  float spacing;
  float hillslope_area; /* catchment below which slopes stop steepening, > 0 */
  float *height, *uplift;
  float *catchment;   /* area that drains through each sample; scratch of the smoothing */
  uint32_t *link;     /* lists of samples: of those that drain to one outlet or pit; for the filling */
  uint8_t *way;       /* direction in which each sample drains; scratch of the filling */
  int8_t (*place)[2]; /* offset of each sample from its lattice point, in 256ths of a cell */
} np_erosion;

/* Allocates a level; heights and uplift are zero, samples on their lattice points. On failure `*out` is empty. */
neph_result np_erosion_create(neph_context *context, unsigned side, float spacing, float hillslope_area,
                              np_erosion *out_erosion);

/* Moves each sample to a random place within its cell, so that rivers do not follow the lattice. */
void np_erosion_scatter(np_erosion *erosion, uint64_t seed);

/* Frees a level. A zeroed one is allowed. */
void np_erosion_destroy(neph_context *context, np_erosion *erosion);

/* Resamples the ground at the lattice points of another level of `side` samples over the same square. */
neph_result np_erosion_resample(neph_context *context, np_monitor *monitor, const np_erosion *erosion, unsigned side,
                                float *out_heights);

/* Fills every basin to its outlet, with a slight slope inside, so that all water reaches the rim. */
neph_result np_erosion_fill_basins(neph_context *context, np_monitor *monitor, np_erosion *erosion);

/* Uplift and river incision over one time step. The bits do not depend on the number of threads or the instruction
 * set. */
neph_result np_erosion_step(neph_context *context, np_monitor *monitor, np_erosion *erosion, float time);

#endif
