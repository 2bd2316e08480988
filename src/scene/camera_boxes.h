/* SPDX-License-Identifier: Apache-2.0 */
/* Whether cameras of each kind have any of a world box in the picture. */
#ifndef NP_SCENE_CAMERA_BOXES_H
#define NP_SCENE_CAMERA_BOXES_H

#include "scene/camera_frame.h"

bool np_camera_perspective_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
bool np_camera_orthographic_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
bool np_camera_sphere_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);
/* By the sphere about the box: it may say yes of one that is just outside. */
bool np_camera_fisheye_sees_box(const np_camera *camera, np_dvec3 low, np_dvec3 high);

#endif
