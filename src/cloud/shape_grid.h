/* SPDX-License-Identifier: Apache-2.0 */
/* Signed distance to a shape on a grid, trilinear between its nodes. Lengths are metres in field coordinates. */
#ifndef NP_CLOUD_SHAPE_GRID_H
#define NP_CLOUD_SHAPE_GRID_H

#include "core/context_private.h"

typedef struct np_shape_grid {
  neph_context *context; /* borrowed */
  int32_t size[3], blocks[3];
  float origin_m[3], step_m;
  float *distance_m; /* distance at each node, negative inside, z fastest */
  float *lowest_m;   /* minimum in each block of cells, including its faces */
  float radius_max_m;
  float age, thickness_m; /* age and thickness of the cloud, which give the age by height */
} np_shape_grid;

/* Allocates nodes from low to high, with a step large enough for the limit on their number. */
neph_result np_shape_grid_init(neph_context *context, const float low_m[3], const float high_m[3], float step_min_m,
                               np_shape_grid *out_grid);
void np_shape_grid_clear(np_shape_grid *grid); /* a zeroed grid is allowed */

/* Computes the bounds; all nodes must have their distance. */
void np_shape_grid_bound(np_shape_grid *grid);

double np_shape_grid_count_bytes(const np_shape_grid *grid);

/* Distance, and the unit vector along its gradient, which may be NULL. Positions beyond the grid are clamped to its
 * border. */
float np_shape_grid_sample(const np_shape_grid *grid, const float at_m[3], float out_normal[3]);

/* Radius of the largest ball inside the surface that touches it near a point, at most radius_max_m. */
float np_shape_grid_compute_radius(const np_shape_grid *grid, const float at_m[3], float distance_m,
                                   const float normal[3]);

/* False only if all distances in the box are at least reach_m. */
bool np_shape_grid_is_near(const np_shape_grid *grid, const float min_m[3], const float max_m[3], float reach_m);

/* Age at a height above the base, for a description's age: tops are young. */
float np_shape_compute_age(float age, float height_m, float thickness_m);

#endif
