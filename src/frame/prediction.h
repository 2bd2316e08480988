/* SPDX-License-Identifier: Apache-2.0 */
/* Predictions of a picture, beside its measured time and error. */
#ifndef NP_FRAME_PREDICTION_H
#define NP_FRAME_PREDICTION_H

#include "plan/plan.h"
#include "stages/stage_times.h"

/* Measures the inputs of a picture that has a target error or a time limit, and revises its plan by them. Other plans
 * are not changed. */
neph_result np_prediction_prepare(const neph_scene *scene, np_plan *plan, np_input_store *store);

/* Copies the predictions of a plan. */
void np_prediction_begin(const np_plan *plan, np_prediction *out);

/* Predicted and measured time of each stage, and of the whole with memory and error, into the log where it is verbose;
 * of the whole into the picture's header, of a picture with a target error or a time limit. The log's numbers are those
 * of np_prediction_log, also for a picture whose plan has not measured its inputs. */
neph_result np_prediction_end(const neph_scene *scene, const np_plan *plan, const np_stage_times *times,
                              np_input_store *store, neph_image *image);

/* Seconds, memory and error of a plan whose inputs are measured, into the log where it is verbose. */
void np_prediction_log(const np_plan *plan);

#endif
