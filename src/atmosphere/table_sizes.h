/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes of the tables of an atmosphere and of its skies, by the error that they may make. */
#ifndef NP_ATMOSPHERE_TABLE_SIZES_H
#define NP_ATMOSPHERE_TABLE_SIZES_H

#include "atmosphere/medium.h"

/* A table of optical depths: how fine it is, and at how many places it is integrated; the rest is splines. */
typedef struct np_depth_sizes {
  int rows, columns, levels;
  int node_rows, node_columns, node_levels;
} np_depth_sizes;

/* Nodes are gathered for; the table that is read is refined from them by splines. */
typedef struct np_moment_sizes {
  int rows, columns;           /* of the table: altitudes and sun cosines */
  int node_rows, node_columns; /* at least 4 */
  int up, down;                /* directions gathered from above and below the horizon */
  int points;                  /* along each; even */
} np_moment_sizes;

/* A table over directions: rows above the true horizon and below it, azimuths on the half circle, both ends included;
 * `node_azimuths` of them traced, the rest splines. */
typedef struct np_view_sizes {
  int up, down, azimuths, node_azimuths;
  int points; /* along a ray of the sky view, even; slices of aerial perspective */
} np_view_sizes;

typedef struct np_table_sizes {
  np_depth_sizes depth;
  np_moment_sizes moments;
  np_view_sizes view, aerial;
} np_table_sizes;

/* Bounds of what sizes there are: of work arrays. */
enum {
  NP_DEPTH_COLUMNS_MAX = 512,
  NP_MOMENT_COLUMNS_MAX = 512,
  NP_MOMENT_NODE_COLUMNS_MAX = 128,
  NP_MOMENT_DIRECTIONS_MAX = 64,
  NP_VIEW_AZIMUTHS_MAX = 257,
  NP_VIEW_POINTS_MAX = 64,
  NP_AERIAL_SLICES_MAX = 128
};

/* Sizes for a tolerance; measured by bench_sky, docs/results/sky.md. */
np_table_sizes np_table_sizes_make(double tolerance);

/* For air of which half the points are drawn to a part (ray_warp.h): so many that both halves are as good; and where
 * profiles have kinks, depths without splines over them. */
void np_table_sizes_adapt(np_table_sizes *sizes, const np_medium *medium);

#endif
