/* SPDX-License-Identifier: Apache-2.0 */
/* The difference of a setting from the finest of its knob is C·|hᵖ − h₀ᵖ|: its own error C·hᵖ less that of the finest.
 * p is searched on a line, C follows from it. */
#include "report/report_fit.h"

#include <assert.h>
#include <math.h>

/* Searched between a sixth and six times the order that is expected. */
static const double order_low = 1.0 / 6.0, order_high = 6.0;
enum { SEARCH_STEPS = 400 };

/* Number of standard errors below which a point only bounds the error. */
static const double sigmas_min = 2.0;

typedef struct curve {
  const np_fit_point *points;
  unsigned count;
  double finest, scale; /* values are taken over the scale, so that powers stay in range */
  bool has_finest;
  double expected; /* order, with its sign */
} curve;

static bool is_of_fit(const curve *c, const np_fit_point *p) {
  const bool is_finest = c->has_finest && p->value == c->finest;
  return !is_finest && isfinite(p->error) && p->error > 0.0 && p->error > sigmas_min * p->sigma;
}

/* Logarithm of the law for C = 1. */
static double get_law(const curve *c, double value, double order) {
  const double power = pow(value / c->scale, order);
  return log(c->has_finest ? fabs(power - pow(c->finest / c->scale, order)) : power);
}

/* Weight of a point in the logarithmic fit: 1/relative error², where the relative error is at least 0.1 %. */
static double get_weight(const np_fit_point *p) {
  const double relative = fmax(p->sigma / p->error, 1e-3);
  return 1.0 / (relative * relative);
}

/* Least sum of squares over C for one order, and the logarithm of that C. */
static double compute_misfit(const curve *c, double order, double *out_log_factor) {
  double weights = 0.0, sum = 0.0, misfit = 0.0;
  for (unsigned i = 0; i < c->count; i++) {
    const np_fit_point *p = &c->points[i];
    if (!is_of_fit(c, p)) continue;
    weights += get_weight(p);
    sum += get_weight(p) * (log(p->error) - get_law(c, p->value, order));
  }
  *out_log_factor = sum / weights;
  assert(weights > 0.0);
  for (unsigned i = 0; i < c->count; i++) {
    const np_fit_point *p = &c->points[i];
    if (is_of_fit(c, p))
      misfit += get_weight(p) * pow(log(p->error) - get_law(c, p->value, order) - *out_log_factor, 2.0);
  }
  return misfit;
}

static double get_order(const curve *c, int step) {
  return c->expected * order_low * pow(order_high / order_low, (double)step / SEARCH_STEPS);
}

static double search_order(const curve *c, np_order_fit *fit) {
  double least = HUGE_VAL, log_factor;
  for (int i = 0; i <= SEARCH_STEPS; i++) {
    const double misfit = compute_misfit(c, get_order(c, i), &log_factor);
    if (!(misfit < least)) continue;
    least = misfit;
    fit->order = get_order(c, i);
    fit->factor = exp(log_factor) * pow(c->scale, -fit->order);
  }
  return least;
}

/* Orders whose misfit is above the least by no more than chance allows. An interval that reaches the end of the search
 * has no end on that side. */
static void bound_order(const curve *c, double limit, np_order_fit *fit) {
  double low = fabs(fit->order), high = low, log_factor;
  for (int i = 0; i <= SEARCH_STEPS; i++) {
    if (compute_misfit(c, get_order(c, i), &log_factor) > limit) continue;
    low = i == 0 ? 0.0 : fmin(low, fabs(get_order(c, i)));
    high = i == SEARCH_STEPS ? HUGE_VAL : fmax(high, fabs(get_order(c, i)));
  }
  const bool is_falling = c->expected < 0.0;
  fit->order_min = is_falling ? -high : low;
  fit->order_max = is_falling ? -low : high;
}

/* A limit by the points' own errors, widened where they scatter more than these say (Birge 1932, Phys. Rev. 40,
 * 207). */
static double compute_limit(double misfit, unsigned count) {
  const double normal = 1.96 * 1.96, scatter = count > 2 ? misfit / (count - 2) : 1.0;
  return misfit + normal * fmax(scatter, 1.0);
}

np_order_fit np_fit_order(const np_fit_point *points, unsigned count, double finest, bool has_finest, double expected) {
  curve c = {.points = points, .count = count, .finest = finest, .has_finest = has_finest, .expected = expected};
  np_order_fit fit = {.is_known = false};
  double logarithms = 0.0;
  for (unsigned i = 0; i < count; i++) {
    if (!is_of_fit(&c, &points[i])) continue;
    logarithms += log(points[i].value);
    fit.point_count++;
  }
  if (fit.point_count < 2) return fit;
  c.scale = exp(logarithms / fit.point_count);
  const double misfit = search_order(&c, &fit);
  bound_order(&c, compute_limit(misfit, fit.point_count), &fit);
  fit.is_known = isfinite(fit.order_min) && isfinite(fit.order_max);
  return fit;
}
