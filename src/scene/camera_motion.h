/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras from files of other programs, frame by frame. */
#ifndef NP_SCENE_CAMERA_MOTION_H
#define NP_SCENE_CAMERA_MOTION_H

#include "scene/animation.h"

/* Reads the file of a scene's camera.motion into an animation, before its own tracks: position, look_at, roll and angle
 * of view, but for keys that the scene gives itself. */
neph_result np_camera_motion_load(const neph_scene *scene, np_animation *animation);

#endif
