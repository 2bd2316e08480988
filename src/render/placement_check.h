/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds that cannot be meant: out of the picture, or of a size that no cloud has. */
#ifndef NP_RENDER_PLACEMENT_CHECK_H
#define NP_RENDER_PLACEMENT_CHECK_H

#include "scene/camera.h"

/* Warns of a cloud whose world box is wholly outside the camera's view, under 10 m or over 1000 km across. What stands
 * before it does not count. */
void np_placement_check(neph_context *context, const np_scene_cloud *cloud, const np_camera *camera, np_dvec3 low,
                        np_dvec3 high);

#endif
