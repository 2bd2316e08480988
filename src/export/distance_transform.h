/* SPDX-License-Identifier: Apache-2.0 */
/* The exact Euclidean distance transform of Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions",
 * 2012, of both sides of a boundary at once. */
#ifndef NP_EXPORT_DISTANCE_TRANSFORM_H
#define NP_EXPORT_DISTANCE_TRANSFORM_H

#include "core/parallel.h"

/* A value that represents no distance yet. */
#define NP_DISTANCE_NONE 1e30f

/* Turns a lattice, x fastest, whose values are NP_DISTANCE_NONE outside and −NP_DISTANCE_NONE inside, into squared
 * distances to the nearest sample of the other side, negative inside. A sample without another side keeps its value. */
neph_result np_distance_transform(neph_context *context, np_monitor *monitor, const unsigned size[3],
                                  const double edge_m[3], float *values);

#endif
