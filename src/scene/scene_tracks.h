/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluation of tracks into the fields of a scene: the key of a track gives type and offset of the field. */
#ifndef NP_SCENE_SCENE_TRACKS_H
#define NP_SCENE_SCENE_TRACKS_H

#include "scene/scene_private.h"

/* Writes the values of all tracks in a frame; step tracks use `step_frame`. */
void np_scene_write_tracks(neph_scene *scene, double frame, double step_frame);

/* Writes the values in a frame of the tracks whose keys begin with a path such as "atmosphere.", but for keys of
 * lists' elements. */
void np_scene_write_section(neph_scene *scene, const char *path, double frame);

#endif
