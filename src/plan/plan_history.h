/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of which a part of the pixels is rendered, in a plan. */
#ifndef NP_PLAN_PLAN_HISTORY_H
#define NP_PLAN_PLAN_HISTORY_H

#include "plan/request.h"

/* Bytes of a pixel's guide and of its place in the frame before: np_pixel_guide and np_reprojected of src/frame. */
enum { NP_HISTORY_GUIDE_BYTES = 28, NP_HISTORY_PLACE_BYTES = 32 };

/* Whether any pixels are not rendered. */
bool np_plan_is_reconstructed(const neph_scene *scene);

/* Share of the pixels that is rendered in the mean over a block of frames, if the camera rests. */
double np_plan_get_rendered_share(const neph_scene *scene);

/* Refuses pictures that cannot be filled in from other frames or pixels. */
neph_result np_plan_check_history(const neph_scene *scene, const np_request *request);

/* Bytes of the picture that is filled in, besides the film. */
double np_plan_predict_reconstruction_bytes(const neph_scene *scene, const np_request *request);

#endif
