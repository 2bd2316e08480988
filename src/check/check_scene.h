/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of scenes with all their files. */
#ifndef NP_CHECK_CHECK_SCENE_H
#define NP_CHECK_CHECK_SCENE_H

#include "check/findings.h"

/* Checks a frame of a scene, which findings call `name`. */
neph_result np_check_scene_frame(neph_check *check, const neph_scene *scene, const char *name, int frame);

#endif
