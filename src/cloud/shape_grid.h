/* SPDX-License-Identifier: Apache-2.0 */
/* The signed distance to a given shape on a grid, trilinear between its nodes. Lengths are metres in the field's
 * coordinates. */
#ifndef NP_CLOUD_SHAPE_GRID_H
#define NP_CLOUD_SHAPE_GRID_H

#include "core/context_private.h"

typedef struct np_shape_grid {
  neph_context *context; /* borrowed */
  int32_t size[3], blocks[3];
  float origin_m[3], step_m;
  float *distance_m; /* at the nodes, negative inside, z fastest */
  float *lowest_m;   /* of each block of cells, its faces included */
  float radius_max_m;
  float age, thickness_m; /* of the cloud, from which its age follows by height */
} np_shape_grid;

/* Makes nodes from low to high, no more than lets them be held. */
neph_result np_shape_grid_init(neph_context *context, const float low_m[3], const float high_m[3], float step_min_m,
                               np_shape_grid *out_grid);
void np_shape_grid_clear(np_shape_grid *grid); /* a zeroed grid is allowed */

/* After all nodes have their distance. */
void np_shape_grid_bound(np_shape_grid *grid);

double np_shape_grid_count_bytes(const np_shape_grid *grid);

/* Distance, and the unit vector along its gradient, which may be NULL. Beyond the grid its border's value. */
float np_shape_grid_sample(const np_shape_grid *grid, const float at_m[3], float out_normal[3]);

/* Radius of the largest ball that touches the surface near a point from inside, at most radius_max_m. */
float np_shape_grid_compute_radius(const np_shape_grid *grid, const float at_m[3], float distance_m,
                                   const float normal[3]);

/* False only if no distance in the box is below reach_m. */
bool np_shape_grid_is_near(const np_shape_grid *grid, const float min_m[3], const float max_m[3], float reach_m);

/* Age at a height above the base, for the age that a description has: tops are young. */
float np_shape_compute_age(float age, float height_m, float thickness_m);

#endif
