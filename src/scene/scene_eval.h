/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in one frame, as a value. */
#ifndef NP_SCENE_SCENE_EVAL_H
#define NP_SCENE_SCENE_EVAL_H

#include "scene/scene_private.h"

/* Evaluates a scene in a frame, which may lie between two: a copy of its description, into which tracks write numbers.
 *
 * The copy borrows texts, lists of points, documents, tracks and assets, and owns its lists of clouds and layers, names
 * of weather maps, and tiles of clouds whose extent is animated. It is valid as long as `scene`, which stays as it is:
 * threads may evaluate one scene at once. An evaluated scene can be evaluated in another frame.
 *
 * out_scene  ended by np_scene_eval_clear; empty on failure, when that changes nothing.
 */
neph_result np_scene_eval(const neph_scene *scene, double frame, neph_scene *out_scene);

/* Evaluates a scene within the exposure of a frame: tracks of steps have their values of `step_frame`, so that no time
 * of the exposure crosses a cut. */
neph_result np_scene_eval_exposure(const neph_scene *scene, double frame, double step_frame, neph_scene *out_scene);

/* Frees the parts that an evaluated scene owns. */
void np_scene_eval_clear(neph_scene *evaluated);

#endif
