/* SPDX-License-Identifier: Apache-2.0 */
/* Properties of a scene over all of its frames. */
#ifndef NP_SCENE_SEQUENCE_H
#define NP_SCENE_SEQUENCE_H

#include "scene/scene_private.h"

/* Whether frames differ: by tracks, moving clouds, or a moving sun. */
bool np_scene_is_sequence(const neph_scene *scene);

/* Whether frames reuse pixels of earlier frames. */
bool np_scene_has_history(const neph_scene *scene);

/* First frame of the block of render.history_frames that contains a frame; blocks are counted from frame 1. */
int np_scene_get_history_first(const neph_scene *scene, int frame);

/* Whether light is constant over all frames: at most the camera moves. */
bool np_scene_has_still_light(const neph_scene *scene);

/* Whether clouds and their surroundings, except the directions of sun and moon, are the same in two frames. */
bool np_scene_stays_between(const neph_scene *scene, int first, int last);

/* Computes the extent of the camera's motion over its tracks, after a scene is read. */
void np_scene_derive_reach(neph_scene *scene);

#endif
