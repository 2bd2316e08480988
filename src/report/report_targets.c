/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_targets.h"

#include <math.h>

static const double targets[NP_REPORT_TARGETS] = {0.1, 0.03, 0.01, 0.003};

/* ---- The front ---- */

static bool is_beaten(const neph_report *report, const np_setting *setting) {
  const double cpu_s = np_setting_get_cpu_s(setting), error = setting->error.value;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *other = &report->settings[i];
    const double other_s = np_setting_get_cpu_s(other), other_error = other->error.value;
    if (other == setting || !other->run_count) continue;
    if (other_s <= cpu_s && other_error <= error && (other_s < cpu_s || other_error < error)) return true;
  }
  return false;
}

void np_report_mark_front(neph_report *report) {
  for (unsigned i = 0; i < report->setting_count; i++) {
    np_setting *setting = &report->settings[i];
    setting->is_on_front = setting->run_count && isfinite(setting->error.value) && !is_beaten(report, setting);
  }
}

unsigned np_report_list_front(const neph_report *report, const np_setting **out) {
  unsigned count = 0;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *s = &report->settings[i];
    if (!s->is_on_front) continue;
    unsigned at = count++;
    for (; at > 0 && np_setting_get_cpu_s(out[at - 1]) > np_setting_get_cpu_s(s); at--) out[at] = out[at - 1];
    out[at] = s;
  }
  return count;
}

/* ---- Targets ---- */

double np_cost_model_count_samples(const np_cost_model *model, double error) {
  if (isnan(model->noise) || isnan(model->bias)) return (double)NAN;
  const double room = error * error - model->bias * model->bias;
  if (!(room > 0.0)) return HUGE_VAL;
  const double share = sqrt(room) / model->noise; /* share of one sample's noise */
  return fmax(ceil(pow(share, 1.0 / model->order) - 1e-9), 1.0);
}

static double count_seconds(const np_cost_model *model, double samples) {
  return model->stage_s + model->sample_s * samples;
}

static np_cost_model make_model(const np_setting *s, double order, double noise, double bias) {
  const double cpu_s = np_setting_get_cpu_s(s);
  return (np_cost_model){.stage_s = s->stage_s,
                         .sample_s = fmax(cpu_s - s->stage_s, 0.0) / s->sample_count,
                         .bias = s->integrator == NEPH_INTEGRATOR_PATH ? 0.0 : bias, /* it has none but by its limits */
                         .noise = noise * pow(s->sample_count, -order),
                         .order = order};
}

/* The bias; if noise hides it, half of its upper bound. */
static double get_bias(neph_bounded bias) { return bias.min > 0.0 ? bias.value : fmax(bias.value, 0.5 * bias.max); }

/* Order of the noise in the samples, by the curve of its integrator. */
static double get_order(const neph_report *report, const np_setting *setting) {
  for (unsigned i = 0; i < report->curve_count; i++) {
    const np_curve *curve = &report->curves[i];
    const bool is_its =
        np_knob_is_of_samples(curve->knob) && (unsigned)curve->knob->of == (unsigned)setting->integrator;
    if (is_its && curve->fit.is_known && curve->fit.point_count > 2) return curve->fit.order;
  }
  return -0.5;
}

static unsigned count_measured(const neph_report *report, unsigned family) {
  unsigned most = 0;
  for (unsigned i = 0; i < report->setting_count; i++) {
    const np_setting *s = &report->settings[i];
    if (s->run_count && s->family == family && s->sample_count > most) most = s->sample_count;
  }
  return most;
}

static double predict(const np_cost_model *model, double error, double *out_samples) {
  *out_samples = np_cost_model_count_samples(model, error);
  return count_seconds(model, *out_samples);
}

/* Offers a setting to a target: the cheapest stays. */
static void offer(const neph_report *report, const np_setting *s, np_target *target) {
  const double order = get_order(report, s);
  const np_cost_model middle = make_model(s, order, s->noise.value, get_bias(s->bias)),
                      low = make_model(s, order, s->noise.min, s->bias.min),
                      high = make_model(s, order, s->noise.max, s->bias.max);
  double samples, ignored;
  const double cpu_s = predict(&middle, target->error, &samples);
  if (!(samples < 1e9) || (target->setting && cpu_s >= target->cpu_s)) return;
  target->setting = s;
  target->sample_count = (unsigned)samples;
  target->cpu_s = cpu_s;
  target->cpu_min_s = predict(&low, target->error, &ignored);
  target->cpu_max_s = predict(&high, target->error, &ignored);
  target->is_extrapolated = samples > 2.0 * count_measured(report, s->family);
}

void np_report_choose_targets(neph_report *report) {
  for (int t = 0; t < NP_REPORT_TARGETS; t++) {
    report->targets[t] = (np_target){.error = targets[t]};
    for (unsigned i = 0; i < report->setting_count; i++) {
      const np_setting *s = &report->settings[i];
      if (s->run_count && isfinite(s->error.value)) offer(report, s, &report->targets[t]);
    }
  }
}
