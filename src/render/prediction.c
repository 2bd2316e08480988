/* SPDX-License-Identifier: Apache-2.0 */
#include "render/prediction.h"

#include <math.h>

#include "image/image_private.h"
#include "render/stages.h"

static bool is_wanted(const np_plan *plan) {
  return isfinite(plan->desc.target_error) || isfinite(plan->desc.time_limit_s);
}

neph_result np_prediction_prepare(const neph_scene *scene, np_plan *plan) {
  return is_wanted(plan) ? np_plan_measure_fill(scene, plan) : NEPH_OK;
}

neph_result np_prediction_begin(const neph_scene *scene, const np_plan *plan) {
  np_prediction *p = &plan->times->prediction;
  *p = (np_prediction){.start_s = np_cpu_time_s(), .is_wanted = is_wanted(plan)};
  p->seconds = np_stages_count_cost(plan).seconds;
  p->error = hypot(plan->bias, plan->noise);
  return p->is_wanted ? np_plan_predict_memory(scene, plan, &p->bytes) : NEPH_OK;
}

static void log_stages(const np_plan *plan) {
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const double predicted_s = plan->stages[i].cost.seconds, measured_s = plan->times->cpu_s[i];
    if (fmax(predicted_s, measured_s) >= 0.01)
      np_log(plan->context, NEPH_LOG_DEBUG, "%s: predicted %.3g s of one core, measured %.3g s",
             np_stage_get_row((np_stage)i)->name, predicted_s, measured_s);
  }
  np_log(plan->context, NEPH_LOG_DEBUG, "estimate of the error: measured %.3g s", plan->times->error_s);
}

/* All that was built is known by then. */
static double predict_by_pilots(const np_plan *plan) {
  double seconds = plan->times->prediction.sampling_s;
  for (int i = 0; i < NP_STAGE_INTEGRATOR; i++) seconds += plan->times->cpu_s[i];
  return seconds;
}

static neph_result write_pilots(const np_plan *plan, neph_image *image) {
  const np_prediction *p = &plan->times->prediction;
  const double seconds = predict_by_pilots(plan), error = hypot(plan->bias, p->noise);
  np_log(plan->context, NEPH_LOG_DEBUG, "prediction by pilots: %.3g s of one core, error %.3g %%", seconds,
         100.0 * error);
  neph_result result = np_image_set_real(image, "nephos:pilotSeconds", seconds);
  return result ? result : np_image_set_real(image, "nephos:pilotError", error);
}

neph_result np_prediction_end(const np_plan *plan, neph_image *image) {
  const np_prediction *p = &plan->times->prediction;
  const double measured_s = np_cpu_time_s() - p->start_s;
  log_stages(plan);
  if (!p->is_wanted) return NEPH_OK;
  np_log(plan->context, NEPH_LOG_DEBUG, "prediction: %.3g s of one core, %.3g MB, error %.3g %%; measured %.3g s",
         p->seconds, 1e-6 * p->bytes, 100.0 * p->error, measured_s);
  neph_result result = np_image_set_real(image, "nephos:predictedSeconds", p->seconds);
  if (!result) result = np_image_set_real(image, "nephos:predictedBytes", p->bytes);
  if (!result) result = np_image_set_real(image, "nephos:predictedError", p->error);
  if (!result) result = np_image_set_real(image, "nephos:cpuSeconds", measured_s);
  return result || !p->has_pilots ? result : write_pilots(plan, image);
}
