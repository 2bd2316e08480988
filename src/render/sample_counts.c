/* SPDX-License-Identifier: Apache-2.0 */
#include "render/sample_counts.h"

#include <math.h>
#include <stdbool.h>

/* Degrees of freedom that the picture's mean has beside those of the neighbours: eight samples may miss a cloud's edge
 * altogether. */
static const double usual_freedom = 0.25;

enum { NEIGHBOURS = 9, MIDDLE = 4 };

/* A variance, and the number of independent squares that it is the mean of. */
typedef struct estimate {
  double variance, freedom;
} estimate;

static const np_pilot *get_neighbour(const np_pilot *at, size_t stride, int k) {
  return at + (ptrdiff_t)stride * (k / 3 - 1) + (k % 3 - 1);
}

/* Variance of samples about the mean of their pixel. */
static estimate pool_within(const np_pilot *at, size_t stride) {
  double squares = 0.0, freedom = 0.0;
  for (int k = 0; k < NEIGHBOURS; k++) {
    const np_pilot *p = get_neighbour(at, stride, k);
    if (k == MIDDLE || !(p->count > 1.0f)) continue;
    squares += (double)p->squares;
    freedom += (double)p->count - 1.0;
  }
  return (estimate){freedom > 0.0 ? squares / freedom : 0.0, freedom};
}

/* Sums over neighbours at d from the pixel along an axis: of d, d², d·x. */
typedef struct axis_sums {
  double d, dd, dx;
} axis_sums;

/* Squares that a slope along an axis explains; the slope's own goes to `out_slope`. */
static double explain(const axis_sums *a, double count, double x, double *out_slope) {
  const double spread = a->dd - a->d * a->d / count, product = a->dx - a->d * x / count;
  *out_slope = spread > 0.0 ? product / spread : 0.0;
  return *out_slope * product;
}

/* Variance of a coordinate of the tent filter's samples, in pixels². */
static const double tent_variance = 1.0 / 6.0;

/* Variance of single samples about a plane through them, and that of the plane's slope within a pixel. */
static estimate fit_plane(const np_pilot *at, size_t stride) {
  axis_sums axis[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  double count = 0.0, x = 0.0, xx = 0.0, slope[2];
  for (int k = 0; k < NEIGHBOURS; k++) {
    const np_pilot *p = get_neighbour(at, stride, k);
    const double d[2] = {k % 3 - 1, k / 3 - 1}, value = (double)p->mean;
    if (k == MIDDLE || !(p->count > 0.0f)) continue;
    for (int a = 0; a < 2; a++) {
      axis[a].d += d[a];
      axis[a].dd += d[a] * d[a];
      axis[a].dx += d[a] * value;
    }
    count += 1.0;
    x += value;
    xx += value * value;
  }
  const double freedom = count - 3.0;
  if (!(freedom > 0.0)) return (estimate){0.0, 0.0};
  double rest = xx - x * x / count;
  for (int a = 0; a < 2; a++) rest -= explain(&axis[a], count, x, &slope[a]);
  const double within = tent_variance * (slope[0] * slope[0] + slope[1] * slope[1]);
  return (estimate){fmax(rest, 0.0) / freedom + within, freedom};
}

static double compute_level(const np_pilot *at, size_t stride) {
  double sum = 0.0, count = 0.0;
  for (int k = 0; k < NEIGHBOURS; k++) {
    const np_pilot *p = get_neighbour(at, stride, k);
    if (k == MIDDLE || !(p->count > 0.0f)) continue;
    sum += (double)p->mean;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

double np_sample_rule_estimate_spread(const np_sample_rule *rule, const np_pilot *at, size_t stride) {
  const estimate e = rule->first > 1 ? pool_within(at, stride) : fit_plane(at, stride);
  const double level = compute_level(at, stride);
  if (!(e.freedom > 0.0)) return rule->usual_spread;
  if (!(level > 0.0)) return 0.0;
  const double fade = level < rule->dim ? level / rule->dim : 1.0; /* its error does not count where it is dark */
  const double own = e.variance * pow(fade / fmax(level, rule->dim), 2.0), weight = e.freedom + usual_freedom;
  return (e.freedom * own + usual_freedom * fade * rule->usual_spread) / weight;
}

double np_sample_rule_count(const np_sample_rule *rule, double spread) {
  const double wanted = rule->gain > 0.0 ? pow(rule->gain * spread, rule->power) : 0.0;
  return fmin(fmax(wanted, rule->min), rule->max);
}

uint32_t np_sample_rule_round(double count, double u) { return (uint32_t)floor(count + u); }
