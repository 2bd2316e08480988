/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of combinations of camera keys. */
#ifndef NP_SCENE_SCENE_CHECK_CAMERA_H
#define NP_SCENE_SCENE_CHECK_CAMERA_H

#include "scene/scene_fail.h"

/* Checks position and look_at. */
neph_result np_scene_check_view(const neph_scene *scene, np_scene_problems *problems);

/* Checks that motion blur has no output that needs a single moment. */
neph_result np_scene_check_motion_blur(const neph_scene *scene, np_scene_problems *problems);

/* Checks that the camera's keys define an exposure, if previews need one. */
neph_result np_scene_check_exposure(const neph_scene *scene, np_scene_problems *problems);

/* Checks the other keys. */
neph_result np_scene_check_camera(const neph_scene *scene, np_scene_problems *problems);

#endif
