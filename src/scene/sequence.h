/* SPDX-License-Identifier: Apache-2.0 */
/* A scene over all of its frames. */
#ifndef NP_SCENE_SEQUENCE_H
#define NP_SCENE_SEQUENCE_H

#include "scene/scene_private.h"

/* Whether frames differ: by tracks, by clouds that move, by a sun that does. */
bool np_scene_is_sequence(const neph_scene *scene);

/* Whether frames take pixels from those before them. */
bool np_scene_has_history(const neph_scene *scene);

/* First frame of the block, of render.history_frames counted from frame 1, that a frame is in. */
int np_scene_get_history_first(const neph_scene *scene, int frame);

/* Whether all that light depends on is the same in all frames: the camera alone may move. */
bool np_scene_has_still_light(const neph_scene *scene);

/* Whether the clouds, and all that lies around them but the directions of sun and moon, are the same from one frame to
 * another. */
bool np_scene_stays_between(const neph_scene *scene, int first, int last);

/* Derives the reach of the camera from its tracks, once a scene is read. */
void np_scene_derive_reach(neph_scene *scene);

#endif
