/* SPDX-License-Identifier: Apache-2.0 */
/* Predictions of a picture, kept beside what came of them. */
#ifndef NP_FRAME_PREDICTION_H
#define NP_FRAME_PREDICTION_H

#include "plan/plan.h"
#include "stages/stage_times.h"

/* Before a picture with a target error or a time limit is begun: measures what clouds fill, by which its plan is
 * revised. Other pictures are left as they are. */
neph_result np_prediction_prepare(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Notes what the plan predicts. */
neph_result np_prediction_begin(const neph_scene *scene, const np_plan *plan, np_prediction *out);

/* Predicted and measured time of each stage, and of the whole with memory and error, into the log where it is verbose;
 * of the whole into the picture's header, of a picture with a target error or a time limit. The log's numbers are those
 * of np_prediction_log, also for a picture whose plan was made without measuring what clouds fill. */
neph_result np_prediction_end(const neph_scene *scene, const np_plan *plan, const np_stage_times *times,
                              np_input_store *store, neph_image *image);

/* Seconds, memory and error of a plan that has measured what clouds fill, into the log where it is verbose. */
neph_result np_prediction_log(const neph_scene *scene, const np_plan *plan);

#endif
