/* SPDX-License-Identifier: Apache-2.0 */
/* The moment that a scene is in. */
#ifndef NP_SCENE_SCENE_TIME_H
#define NP_SCENE_SCENE_TIME_H

#include "core/time_text.h"
#include "scene/scene_private.h"

/* Time of a scene in its frame; 1970 where it has no sun.time. Its text was read before: NEPH_ERROR_BAD_SCENE, with a
 * message, where the file of its zone has changed since. */
neph_result np_scene_time_read(const neph_scene *scene, np_time *out_time);

#endif
