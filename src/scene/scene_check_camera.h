/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of the camera's keys together. */
#ifndef NP_SCENE_SCENE_CHECK_CAMERA_H
#define NP_SCENE_SCENE_CHECK_CAMERA_H

#include "scene/scene_fail.h"

/* Checks position and look_at. */
neph_result np_scene_check_view(const neph_scene *scene, np_scene_problems *problems);

/* Checks that no output of one moment is asked for. */
neph_result np_scene_check_motion_blur(const neph_scene *scene, np_scene_problems *problems);

/* Checks that previews can be exposed by the camera. */
neph_result np_scene_check_exposure(const neph_scene *scene, np_scene_problems *problems);

/* Checks the other keys. */
neph_result np_scene_check_camera(const neph_scene *scene, np_scene_problems *problems);

#endif
