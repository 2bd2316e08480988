/* SPDX-License-Identifier: Apache-2.0 */
/* Animated cameras from files of other programs. */
#ifndef NP_SCENE_CAMERA_MOTION_H
#define NP_SCENE_CAMERA_MOTION_H

#include "scene/animation.h"

/* Reads the file of camera.motion into tracks, before the scene's own: position, look_at, roll and angle of view,
 * except for keys that the scene sets. */
neph_result np_camera_motion_load(const neph_scene *scene, np_animation *animation);

#endif
