/* SPDX-License-Identifier: Apache-2.0 */
/* Values of tracks in the fields of a scene: the key of a track has type and place of its field. */
#ifndef NP_SCENE_SCENE_TRACKS_H
#define NP_SCENE_SCENE_TRACKS_H

#include "scene/scene_private.h"

/* Writes the values of all tracks in a frame; those of steps in `step_frame`. */
void np_scene_write_tracks(neph_scene *scene, double frame, double step_frame);

#endif
