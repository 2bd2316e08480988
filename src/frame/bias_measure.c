/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/bias_measure.h"

enum { STEPS = 400 };

/* Few probes know their spread only roughly: Student's distribution of four degrees, its density but for a factor, and
 * its integral. */
static double get_student_density(double t) { return pow(1.0 + 0.25 * t * t, -2.5); }

static double get_student_integral(double t) {
  const double u = t / sqrt(4.0 + t * t);
  return 0.5 + 0.25 * u * (3.0 - u * u);
}

/* Weight of the shift that was measured where the bias is b: m is anywhere in [−b, b], as in ten drawn scenes, where
 * |m|/b was 0.07 to 0.99 with a mean of 0.67. */
static double weigh_shift(double b, const np_uncertain *shift) {
  if (!(shift->deviation > 0.0)) return 1.0;
  const double high = get_student_integral((b - shift->value) / shift->deviation),
               low = get_student_integral((-b - shift->value) / shift->deviation);
  return (high - low) * shift->deviation / b;
}

/* Weight of b by the model, whose logarithm is spread normally, and by the measures. */
static double weigh_bias(double b, const np_bias_model *model, const np_bias_measure *measured) {
  const double model_z = log(b / model->bias) / log(model->factor);
  const np_uncertain *square = &measured->square;
  const double z = square->deviation > 0.0 ? (square->value - b * b) / square->deviation : 0.0;
  return exp(-0.5 * model_z * model_z) * get_student_density(z) * weigh_shift(b, &measured->shift);
}

/* Mean of log b and its bounds, over four decades of b². */
neph_bounded np_bias_combine(const np_bias_model *model, const np_bias_measure *measured) {
  double weight[STEPS], all = 0.0, mean = 0.0, below = 0.0;
  const double lowest = log(model->bias) - log(1e2), step = 2.0 * log(1e2) / STEPS;
  for (int i = 0; i < STEPS; i++) {
    weight[i] = weigh_bias(exp(lowest + i * step), model, measured);
    all += weight[i];
    mean += weight[i] * (lowest + i * step);
  }
  neph_bounded out = {exp(mean / all), exp(lowest), exp(lowest)};
  for (int i = 0; i < STEPS; i++) {
    if (below < 0.025 * all) out.min = exp(lowest + i * step);
    if (below < 0.975 * all) out.max = exp(lowest + i * step);
    below += weight[i];
  }
  return out;
}
