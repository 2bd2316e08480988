/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of a given shape: the first level of their balls, or a distance on a grid, comes from spheres, curves, a
 * closed mesh or a height map. */
#ifndef NP_CLOUD_SHAPE_H
#define NP_CLOUD_SHAPE_H

#include "cloud/cloud_model.h"

/* Makes the grid, where there is one, and the map of the shape's shadow, for rain. */
neph_result np_shape_build(np_cloud_model *model, np_monitor *monitor);

/* Adds the first level: balls of spheres and curves, perhaps none. */
neph_result np_shape_add_balls(np_cloud_model *model, np_monitor *monitor, float blend_m, float bin_m);

/* Warns where billows reach beyond the field. */
void np_shape_check_billows(const np_cloud_model *model);

#endif
