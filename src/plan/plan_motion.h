/* SPDX-License-Identifier: Apache-2.0 */
/* Motion of clouds about the frame, in a plan: baked clouds move by their wind, imported ones by their velocities. */
#ifndef NP_PLAN_PLAN_MOTION_H
#define NP_PLAN_PLAN_MOTION_H

#include "scene/scene_private.h"

bool np_plan_has_velocity(const np_scene_cloud *cloud);
bool np_plan_has_wind(const np_scene_cloud *cloud);

#endif
