/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/sample_counts.h"

#include <math.h>
#include <stdbool.h>

/* A spread below this share of the picture's mean belongs to a quiet place, for which the mean counts less. */
static const double quiet_share = 0.02;

enum { NEIGHBOURS = 9, MIDDLE = 4 };

/* A variance, and the number of independent squares that it is the mean of. */
typedef struct estimate {
  double variance, freedom;
} estimate;

static const np_pilot *get_neighbour(const np_pilot *at, size_t stride, int k) {
  return at + (ptrdiff_t)stride * (k / 3 - 1) + (k % 3 - 1);
}

/* Variance of samples about the mean of their pixel. The largest of the neighbours' counts no more than the second: a
 * single bright path raises no estimate of the pixels around it. */
static estimate pool_within(const np_pilot *at, size_t stride) {
  double squares = 0.0, freedom = 0.0, largest = 0.0, second = 0.0;
  for (int k = 0; k < NEIGHBOURS; k++) {
    const np_pilot *p = get_neighbour(at, stride, k);
    const double own = (double)p->squares;
    if (k == MIDDLE || !(p->count > 1.0f)) continue;
    squares += own;
    freedom += (double)p->count - 1.0;
    second = fmax(second, fmin(own, largest));
    largest = fmax(largest, own);
  }
  return (estimate){freedom > 0.0 ? (squares - largest + second) / freedom : 0.0, freedom};
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

/* Fits a plane to the pilots' means: returns the variance of single samples about it, and adds the variance of its
 * slope within a pixel. */
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

/* Mean luminances of the neighbours. */
typedef struct levels {
  double least, median, largest;
} levels;

static levels compute_levels(const np_pilot *at, size_t stride) {
  double means[NEIGHBOURS];
  int count = 0;
  for (int k = 0; k < NEIGHBOURS; k++) {
    const np_pilot *p = get_neighbour(at, stride, k);
    if (k == MIDDLE || !(p->count > 0.0f)) continue;
    int place = count++;
    for (; place > 0 && means[place - 1] > (double)p->mean; place--) means[place] = means[place - 1];
    means[place] = (double)p->mean;
  }
  if (!count) return (levels){0.0, 0.0, 0.0};
  return (levels){means[0], 0.5 * (means[(count - 1) / 2] + means[count / 2]), means[count - 1]};
}

/* The pixel may be as dark as most of its neighbours beside the sun's disk. A mixture of a and b has no larger (σ/T)²
 * than (b − a)²/4ab, at T = 2ab/(a + b) (Bhatia and Davis 2000, "A Better Bound on the Variance"). */
static double compute_relative(double variance, const levels *l, double dim) {
  const double dark = fmax(fmax(l->least, dim), 1e-300), bright = fmax(l->largest, dark);
  const double bound = (bright - dark) * (bright - dark) / (4.0 * dark * bright);
  const double by_largest = variance / (bright * bright), by_median = variance / pow(fmax(l->median, dark), 2.0);
  return fmin(by_median, fmax(by_largest, bound));
}

double np_sample_rule_estimate_spread(const np_sample_rule *rule, const np_pilot *at, size_t stride) {
  const estimate e = rule->first > 1 ? pool_within(at, stride) : fit_plane(at, stride);
  const levels l = compute_levels(at, stride);
  if (!(e.freedom > 0.0)) return rule->usual_spread;
  const double fade = fmin(fmax(l.largest, 0.0) / fmax(rule->dim, 1e-300), 1.0); /* no error counts where all is dark */
  const double own = fade * fade * compute_relative(e.variance, &l, rule->dim);
  if (!(own > 0.0)) return 0.0;
  const double usual = rule->usual_spread * own / (own + quiet_share * rule->usual_spread);
  return (e.freedom * own + rule->usual_freedom * usual) / (e.freedom + rule->usual_freedom);
}

double np_sample_rule_count(const np_sample_rule *rule, double spread) {
  const double wanted = rule->gain > 0.0 ? pow(rule->gain * spread, rule->power) : 0.0;
  return fmin(fmax(wanted, rule->min), rule->max);
}

uint32_t np_sample_rule_round(double count, double u) { return (uint32_t)floor(count + u); }
