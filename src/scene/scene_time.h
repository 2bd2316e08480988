/* SPDX-License-Identifier: Apache-2.0 */
/* Date and time of a scene. */
#ifndef NP_SCENE_SCENE_TIME_H
#define NP_SCENE_SCENE_TIME_H

#include "core/time_text.h"
#include "scene/scene_private.h"

/* Time of a scene in its frame; 1970 if sun.time is not set. */
np_time np_scene_get_time(const neph_scene *scene);

#endif
