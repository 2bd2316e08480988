/* SPDX-License-Identifier: Apache-2.0 */
/* Visibility of a world box for each kind of camera. */
#ifndef NP_SCENE_CAMERA_BOXES_H
#define NP_SCENE_CAMERA_BOXES_H

#include "scene/camera_frame.h"

bool np_camera_perspective_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
bool np_camera_orthographic_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
bool np_camera_sphere_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
/* Tests the bounding sphere of the box: true also for some boxes just outside the view. */
bool np_camera_fisheye_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);

#endif
