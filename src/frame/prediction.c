/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/prediction.h"

#include <math.h>

#include "core/text.h"
#include "image/image_private.h"
#include "plan/stage_rules.h"

static bool is_wanted(const np_plan *plan) {
  return isfinite(plan->request.desc.target_error) || isfinite(plan->request.desc.time_limit_s);
}

neph_result np_prediction_prepare(const neph_scene *scene, np_plan *plan, np_input_store *store) {
  return is_wanted(plan) ? np_plan_measure_fill(scene, plan, store) : NEPH_OK;
}

void np_prediction_begin(const np_plan *plan, np_prediction *p) {
  *p = (np_prediction){.start_s = np_cpu_time_s(), .is_wanted = is_wanted(plan)};
  p->seconds = np_forecast_sum(&plan->forecast).seconds;
  p->error = hypot(plan->forecast.bias, plan->forecast.noise);
  p->bytes = np_plan_predict_memory(plan);
}

static bool is_verbose(const np_plan *plan) { return np_log_is_wanted(plan->request.context, NEPH_LOG_DEBUG); }

/* "; measured 1.2 s" where `measured_s` is not negative. */
static void log_whole(const np_plan *plan, double measured_s) {
  char measured[40] = "";
  if (measured_s >= 0.0) np_print(measured, sizeof measured, "; measured %.3g s", measured_s);
  np_log(plan->request.context, NEPH_LOG_DEBUG, "prediction: %.3g s of one core, %.3g MB, error %.3g %%%s",
         np_forecast_sum(&plan->forecast).seconds, 1e-6 * np_plan_predict_memory(plan),
         100.0 * hypot(plan->forecast.bias, plan->forecast.noise), measured);
}

void np_prediction_log(const np_plan *plan) {
  if (is_verbose(plan)) log_whole(plan, -1.0);
}

static void log_stages(const np_plan *plan, const np_stage_times *times) {
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const double predicted_s = plan->forecast.stages[i].cost.seconds, measured_s = times->cpu_s[i];
    if (fmax(predicted_s, measured_s) >= 0.01)
      np_log(plan->request.context, NEPH_LOG_DEBUG, "%s: predicted %.3g s of one core, measured %.3g s",
             np_stage_get_rule((np_stage)i)->name, predicted_s, measured_s);
  }
  np_log(plan->request.context, NEPH_LOG_DEBUG, "estimate of the error: measured %.3g s", times->error_s);
}

/* The log has the numbers of a plan whose inputs are measured, as `--explain` has: verbosity changes no picture. */
static neph_result log_all(const neph_scene *scene, const np_plan *plan, const np_stage_times *times,
                           np_input_store *store, double measured_s) {
  np_plan measured;
  neph_result result = np_plan_make_measured(scene, plan, store, &measured);
  if (!result) log_stages(&measured, times);
  if (!result) log_whole(&measured, measured_s);
  np_plan_clear(&measured);
  return result;
}

/* All that was built is known by then. */
static double predict_by_pilots(const np_stage_times *times) {
  double seconds = times->prediction.sampling_s;
  for (int i = 0; i < NP_STAGE_INTEGRATOR; i++) seconds += times->cpu_s[i];
  return seconds;
}

static neph_result write_pilots(const np_plan *plan, const np_stage_times *times, neph_image *image) {
  const np_prediction *p = &times->prediction;
  const double seconds = predict_by_pilots(times), error = hypot(plan->forecast.bias, p->noise);
  np_log(plan->request.context, NEPH_LOG_DEBUG, "prediction by pilots: %.3g s of one core, error %.3g %%", seconds,
         100.0 * error);
  neph_result result = np_image_set_real(image, "nephos:pilotSeconds", seconds);
  return result ? result : np_image_set_real(image, "nephos:pilotError", error);
}

neph_result np_prediction_end(const neph_scene *scene, const np_plan *plan, const np_stage_times *times,
                              np_input_store *store, neph_image *image) {
  const np_prediction *p = &times->prediction;
  const double measured_s = np_cpu_time_s() - p->start_s;
  neph_result result = is_verbose(plan) ? log_all(scene, plan, times, store, measured_s) : NEPH_OK;
  if (result || !p->is_wanted) return result;
  result = np_image_set_real(image, "nephos:predictedSeconds", p->seconds);
  if (!result) result = np_image_set_real(image, "nephos:predictedBytes", p->bytes);
  if (!result) result = np_image_set_real(image, "nephos:predictedError", p->error);
  if (!result) result = np_image_set_real(image, "nephos:cpuSeconds", measured_s);
  return result || !p->has_pilots ? result : write_pilots(plan, times, image);
}
