/* SPDX-License-Identifier: Apache-2.0 */
/* Predicted time and memory: functions for the rows of the stage table that take much. */
#ifndef NP_RENDER_STAGE_COSTS_H
#define NP_RENDER_STAGE_COSTS_H

#include "render/plan_stages.h"

typedef np_stage_cost np_stage_predict_fn(const np_plan *plan, const neph_scene *scene);

np_stage_predict_fn np_stage_predict_volumes, np_stage_predict_sun_optical_depth, np_stage_predict_ordinates,
    np_stage_predict_air_shadows, np_stage_predict_integrator;

/* Seconds for one sample of each pixel. */
double np_stage_predict_one_sample(const np_plan *plan);

#endif
