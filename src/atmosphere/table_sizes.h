/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes of the tables of an atmosphere and of its skies, for a tolerance. */
#ifndef NP_ATMOSPHERE_TABLE_SIZES_H
#define NP_ATMOSPHERE_TABLE_SIZES_H

#include "atmosphere/medium.h"

/* Table of optical depths: its size, and the nodes that are integrated; splines fill the rest. */
typedef struct np_depth_sizes {
  int rows, columns, levels;
  int node_rows, node_columns, node_levels;
} np_depth_sizes;

/* Table of moments: the nodes are gathered, and splines refine them to the table. */
typedef struct np_moment_sizes {
  int rows, columns;           /* size of the table: altitudes and sun cosines */
  int node_rows, node_columns; /* 4 or more */
  int up, down;                /* directions gathered above and below the horizon */
  int points;                  /* samples along each direction; even */
} np_moment_sizes;

/* Table over directions: rows above and below the true horizon, azimuths on the half circle, both ends inclusive;
 * `node_azimuths` of them are traced, splines fill the rest. */
typedef struct np_view_sizes {
  int up, down, azimuths, node_azimuths;
  int points; /* samples along a ray of the sky view, even; slices of aerial perspective */
} np_view_sizes;

typedef struct np_table_sizes {
  np_depth_sizes depth;
  np_moment_sizes moments;
  np_view_sizes view, aerial;
} np_table_sizes;

/* Limits of sizes, for work arrays. */
enum {
  NP_DEPTH_COLUMNS_MAX = 512,
  NP_MOMENT_COLUMNS_MAX = 512,
  NP_MOMENT_NODE_COLUMNS_MAX = 128,
  NP_MOMENT_DIRECTIONS_MAX = 64,
  NP_VIEW_AZIMUTHS_MAX = 257,
  NP_VIEW_POINTS_MAX = 64,
  NP_AERIAL_SLICES_MAX = 128
};

/* Sizes for a tolerance, measured by bench_sky (docs/results/sky.md). */
np_table_sizes np_table_sizes_make(double tolerance);

/* Adapts the sizes to a medium: more points for warped rules (ray_warp.h), half of which go to thin layers, and no
 * splines over depths of profiles with kinks. */
void np_table_sizes_adapt(np_table_sizes *sizes, const np_medium *medium);

#endif
