/* SPDX-License-Identifier: Apache-2.0 */
/* Predictions of a picture, kept beside what came of them. */
#ifndef NP_RENDER_PREDICTION_H
#define NP_RENDER_PREDICTION_H

#include "render/plan.h"

/* Before a picture with a target error or a time limit is begun: measures what clouds fill, by which its plan is
 * revised. Other pictures are left as they are. */
neph_result np_prediction_prepare(const neph_scene *scene, np_plan *plan);

/* Notes what the plan predicts, in its times. */
neph_result np_prediction_begin(const neph_scene *scene, const np_plan *plan);

/* Predicted and measured time of each stage into the log; of the whole into the picture's header, of a picture with a
 * target error or a time limit. */
neph_result np_prediction_end(const np_plan *plan, neph_image *image);

#endif
