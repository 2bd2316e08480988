/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes for a tolerance.
 *
 * The error of bilinear tables grows with the square of their spacing, so that rows and columns grow as the root of the
 * accuracy. The error of splines and Gauss rules grows with the fourth power or faster: their nodes grow as the fourth
 * root. At the sizes of the default tolerance, no single table errs by more than half of it. */
#include "atmosphere/table_sizes.h"

#include "atmosphere/medium.h"
#include "atmosphere/ray_warp.h"

/* A count at the default tolerance times `scale`, clamped. */
static int scaled(int count, double scale, int min, int max) { return (int)np_clamp(round(count * scale), min, max); }

static int scaled_even(int count, double scale, int min, int max) {
  return 2 * scaled(count / 2, scale, min / 2, max / 2);
}

/* Number of spline nodes: they are every second row of the table that they fill, ends included. */
static int every_second(int count) { return (count - 1) / 2 + 1; }

np_table_sizes np_table_sizes_make(double tolerance) {
  const double t = np_clamp(tolerance, NP_SKY_TOLERANCE_MIN, NP_SKY_TOLERANCE_MAX) / NP_SKY_TOLERANCE_DEFAULT;
  const double fine = 1.0 / sqrt(t), slow = sqrt(fine);
  np_table_sizes n = {
      .depth = {.rows = scaled(192, fine, 48, 512),
                .columns = scaled(72, fine, 24, 256),
                .levels = scaled(1024, fine, 256, 4096)},
      .moments = {.rows = scaled(48, fine, 24, 256), .columns = scaled(120, fine, 64, NP_MOMENT_COLUMNS_MAX)},
      .view = {.up = scaled(64, fine, 24, 256), .down = scaled(32, fine, 16, 128)},
      .aerial = {.up = scaled(32, fine, 12, 128), .down = scaled(24, fine, 12, 96)},
  };
  n.depth.node_rows = 3 * n.depth.rows / 8;
  n.depth.node_columns = n.depth.columns / 3;
  n.depth.node_levels = n.depth.levels / 4;
  n.moments.node_rows = scaled(14, slow, 8, 48);
  n.moments.node_columns = scaled(28, slow, 16, 96);
  n.moments.up = scaled(10, slow, 5, 32);
  n.moments.down = scaled(5, slow, 3, 16);
  n.moments.points = scaled_even(18, slow, 12, NP_VIEW_POINTS_MAX);
  n.view.azimuths = 1 + scaled_even(56, fine, 24, NP_VIEW_AZIMUTHS_MAX - 1);
  n.view.node_azimuths = every_second(n.view.azimuths);
  n.view.points = scaled_even(32, slow, 16, NP_VIEW_POINTS_MAX);
  n.aerial.azimuths = 1 + scaled_even(32, fine, 16, NP_VIEW_AZIMUTHS_MAX - 1);
  n.aerial.node_azimuths = every_second(n.aerial.azimuths);
  n.aerial.points = scaled(32, fine, 12, NP_AERIAL_SLICES_MAX);
  return n;
}

/* Times as many altitudes in opaque air: else 590 m lie between those at the ground, and light changes with the depth
 * of haze (docs/results/sky.md). */
static const int opaque_rows = 3;

void np_table_sizes_adapt(np_table_sizes *sizes, const np_medium *medium) {
  if (medium->is_opaque) sizes->moments.node_rows *= opaque_rows;
  if (!np_warp_is_needed(medium)) return;
  const int moments = 2 * sizes->moments.points, view = 2 * sizes->view.points;
  sizes->moments.points = moments < NP_VIEW_POINTS_MAX ? moments : NP_VIEW_POINTS_MAX;
  sizes->view.points = view < NP_VIEW_POINTS_MAX ? view : NP_VIEW_POINTS_MAX;
  if (!medium->has_profile_kinks) return;
  sizes->depth.node_rows = sizes->depth.rows;
  sizes->depth.node_columns = sizes->depth.columns;
  sizes->depth.node_levels = sizes->depth.levels;
}
