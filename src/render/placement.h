/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in their places: from a grid's own transform and unit to world and 1/m. */
#ifndef NP_RENDER_PLACEMENT_H
#define NP_RENDER_PLACEMENT_H

#include "core/parallel.h"
#include "light/scene_view.h"
#include "scene/scene_private.h"

typedef struct np_placement {
  np_view_volume view;
  np_affine index_to_world;
  np_dvec3 bounds_min, bounds_max; /* world box of the active samples */
} np_placement;

/* World box of a volume's active samples. */
void np_placement_find_bounds(const np_affine *index_to_world, const neph_volume *volume, np_dvec3 *out_min,
                              np_dvec3 *out_max);

/* Places a volume as its cloud asks: up axis, voxel edge, scale, rotation, position; extinction from its unit.
 * `reference` is the volume whose densest column an optical depth refers to. */
neph_result np_placement_make(const np_scene_cloud *cloud, const neph_volume *volume, const neph_volume *reference,
                              np_monitor *monitor, np_placement *out_placement);

#endif
