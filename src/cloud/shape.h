/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of a given shape: spheres, curves, a closed mesh or a height map define the first level of balls, or a
 * distance grid. */
#ifndef NP_CLOUD_SHAPE_H
#define NP_CLOUD_SHAPE_H

#include "cloud/cloud_model.h"

/* Builds the distance grid, if there is one, and the map of the shape's vertical projection, for rain. */
neph_result np_shape_build(np_cloud_model *model, np_monitor *monitor);

/* Adds the first level: balls of spheres and curves, possibly none. */
neph_result np_shape_add_balls(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m);

/* Warns if billows extend beyond the field. */
void np_shape_check_billows(const np_cloud_model *model);

#endif
