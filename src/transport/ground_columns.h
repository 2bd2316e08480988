/* SPDX-License-Identifier: Apache-2.0 */
/* Ground in the cells' box or close below it: hills hide what is behind them and shine. A cell is solid where ground is
 * above three quarters of its height; ground that is lower shines through the bottom of the box. Light that comes down
 * on a column is kept at its lowest face, so that a sweep leaves there what falls on the ground, or through the bottom
 * of the box. */
#ifndef NP_TRANSPORT_GROUND_COLUMNS_H
#define NP_TRANSPORT_GROUND_COLUMNS_H

#include "transport/border.h"

/* Light of the ground in a column of the finest cells. */
typedef struct np_ground_column {
  bool is_near;      /* false: no ground is near, and the other members are 0 */
  np_spectrum clear; /* radiance under a clear sky, the waves' glint excluded */
  np_spectrum glint; /* np_column_light.glint */
  np_spectrum gain;  /* increase of the radiance by the irradiance on the column's square of the plan, 1/sr */
} np_ground_column;

typedef struct np_ground_columns {
  int32_t size[2];
  np_ground_column *at; /* [j][i]; NULL: no ground is near */
} np_ground_columns;

/* Finds whether ground is near, and marks the solid cells of a grid; none of them may be active, and `holds` is cleared
 * for them. A periodic grid has no ground. */
neph_result np_ground_columns_bury(const np_world *world, np_monitor *monitor, np_transport_grid *grid, bool *holds);

neph_result np_ground_columns_fill(const np_transport_grid *grid, const np_world *world,
                                   const np_sun_optical_depth_source *depths, const float *fade, np_monitor *monitor,
                                   np_ground_columns *out);
void np_ground_columns_clear(neph_context *context, np_ground_columns *columns);

/* Fills a band's radiance of the ground by column of the finest grid or of a coarser one. `outflow` NULL: under a clear
 * sky. */
void np_ground_columns_get(const np_ground_columns *columns, const np_border *border, unsigned band,
                           const np_outflow *outflow, const np_transport_grid *grid, np_column_light *out);

#endif
