/* SPDX-License-Identifier: Apache-2.0 */
/* The moment that a scene is in. */
#ifndef NP_SCENE_SCENE_TIME_H
#define NP_SCENE_SCENE_TIME_H

#include "core/time_text.h"
#include "scene/scene_private.h"

/* Time of a scene in its frame; 1970 where it has no sun.time. */
np_time np_scene_get_time(const neph_scene *scene);

#endif
