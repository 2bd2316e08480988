/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluation of a scene in one frame, as a value. */
#ifndef NP_SCENE_SCENE_EVAL_H
#define NP_SCENE_SCENE_EVAL_H

#include "scene/scene_private.h"

/* Evaluates a scene in a frame, which may be fractional: a copy of its description, into which tracks write their
 * numbers.
 *
 * The copy borrows texts, lists of points, documents, tracks and assets. It owns its lists of clouds and layers, names
 * of weather maps, and tiles of clouds with an animated extent. It is valid as long as `scene`, which does not change:
 * threads may evaluate one scene at once. An evaluated scene can be evaluated in another frame.
 *
 * out_scene freed by np_scene_eval_clear; empty on failure. */
neph_result np_scene_eval(const neph_scene *scene, double frame, neph_scene *out_scene);

/* Evaluates a scene in a frame whose clouds are baked next: NEPH_ERROR_BAD_SCENE if keys of a bake exclude each other
 * in the frame, as a repeat and a wind across both axes do. */
neph_result np_scene_eval_bakes(const neph_scene *scene, double frame, neph_scene *out_scene);

/* Evaluates a scene within the exposure of a frame. Step tracks have their values of `step_frame`, so that no exposure
 * crosses a cut. */
neph_result np_scene_eval_exposure(const neph_scene *scene, double frame, double step_frame, neph_scene *out_scene);

/* Frees the parts that an evaluated scene owns. */
void np_scene_eval_clear(neph_scene *evaluated);

#endif
