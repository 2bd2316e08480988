/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/pilots.h"

#include "frame/pilot_points.h"

/* ---- Noise of the picture ---- */

/* Mean of Var/T² over pixels that count, its standard error, and the mean number of samples. */
typedef struct picture_noise {
  double square, error, samples;
} picture_noise;

typedef struct model {
  const np_pilot_points *points;
  const np_sample_rule *rule; /* NULL: 2^level samples for every pixel */
  unsigned level;
  double exponent;
} model;

/* Variance of a point's mean of `count` samples: linear in their reciprocal between two levels. */
static double get_variance(const model *m, const np_pilot_point *p, double count) {
  const unsigned last = m->points->levels - 1;
  const unsigned level = (unsigned)fmin(floor(log2(count)), last);
  const double here = p->variance[level], most = (double)(1u << level);
  if (level == last) return here * pow(most / count, m->exponent);
  const double share = 2.0 * most / count - 1.0; /* 1 at this level, 0 at the next */
  return share * here + (1.0 - share) * p->variance[level + 1];
}

static picture_noise predict(const model *m) {
  double sum = 0.0, squares = 0.0, cross = 0.0, shares = 0.0, shares2 = 0.0, all = 0.0, samples = 0.0;
  for (unsigned i = 0; i < m->points->count; i++) {
    const np_pilot_point *p = &m->points->at[i];
    const double n = m->rule ? np_sample_rule_count(m->rule, p->spread) : (double)(1u << m->level);
    samples += p->share * n;
    all += p->share;
    if (!(p->mean > m->points->dim)) continue;
    const double square = get_variance(m, p, n) / (p->mean * p->mean);
    sum += p->share * square;
    shares += p->share;
    squares += pow(p->share * square, 2.0);
    cross += p->share * p->share * square;
    shares2 += p->share * p->share;
  }
  if (!(shares > 0.0)) return (picture_noise){0.0, 0.0, samples / all};
  const double mean = sum / shares, residual = squares - 2.0 * mean * cross + mean * mean * shares2;
  return (picture_noise){mean, sqrt(fmax(residual, 0.0)) / shares, samples / all};
}

static double get_noise(const np_pilot_points *points, unsigned level) {
  return predict(&(model){.points = points, .level = level, .exponent = 1.0}).square;
}

/* Exponents of independent samples, of a tracer's, which are independent but for their places in the pixel, and of the
 * best that points in two dimensions do. */
static const double exponent_min = 1.0, exponent_traced = 1.15, exponent_usual = 1.5, exponent_max = 2.0;

static double measure_exponent(const np_pilot_points *points, bool is_traced) {
  const double one = get_noise(points, 0), all = get_noise(points, points->levels - 1);
  if (is_traced) return exponent_traced;
  if (points->levels < 2 || !(one > 0.0) || !(all > 0.0)) return exponent_usual;
  return fmin(fmax(log2(one / all) / (points->levels - 1), exponent_min), exponent_max);
}

/* ---- The rule ---- */

enum { GAIN_STEPS = 24 };

/* Number of standard errors that are added to the estimated noise. A few pixels may have most of the noise, so that
 * most lattices of pilots underestimate it. */
static const double caution = 1.0;

/* Whether a rule leaves no more than a noise; the prediction goes to `out`. */
static bool is_enough(const model *m, double noise, np_pilots *out) {
  const picture_noise n = predict(m);
  out->noise = sqrt(n.square);
  out->samples = n.samples;
  return n.square + caution * n.error <= noise * noise;
}

/* Least gain whose noise does not exceed the target; noise falls as the gain grows. */
static void solve_for_gain(const np_pilot_points *points, double noise, np_pilots *out) {
  const model m = {points, &out->rule, 0, out->exponent};
  double low = 0.0, high = log(1e12);
  out->rule.gain = 0.0;
  if (is_enough(&m, noise, out)) return;
  for (int i = 0; i < GAIN_STEPS; i++) {
    const double middle = 0.5 * (low + high);
    out->rule.gain = exp(middle);
    *(is_enough(&m, noise, out) ? &high : &low) = middle;
  }
  out->rule.gain = exp(high);
  (void)is_enough(&m, noise, out);
}

static void set_freedom(np_pilot_points *points, double freedom, np_sample_rule *rule) {
  rule->usual_freedom = freedom;
  for (unsigned i = 0; i < points->count; i++)
    points->at[i].spread = np_sample_rule_estimate_spread(rule, &points->at[i].around[NP_PILOT_MIDDLE], 3);
}

/* Ratio to the least number of samples up to which a rule is accepted, if its counts vary less by chance. */
static const double as_good = 1.03;

/* Solves for the rule. Spreads of few samples are noisy, above all where rare paths are bright: they are averaged with
 * the picture's mean spread, with the largest weight that needs hardly more samples than the optimum. */
static void solve_for_rule(np_pilot_points *points, double noise, np_pilots *out) {
  static const double freedoms[] = {0.25, 1.0, 4.0, 16.0, 64.0, 256.0};
  np_pilots best = *out;
  double least = HUGE_VAL;
  for (size_t i = 0; i < sizeof freedoms / sizeof *freedoms; i++) {
    set_freedom(points, freedoms[i], &out->rule);
    solve_for_gain(points, noise, out);
    least = fmin(least, out->samples);
    if (out->samples <= as_good * least) best = *out;
  }
  *out = best;
}

double np_pilots_predict_samples(const np_pilots *pilots, double noise) {
  return fmax(pow(pilots->noise_of_one / noise, 2.0 / pilots->exponent), 1.0);
}

/* ---- Size of the lattice ---- */

enum { POINTS_MIN = 256, TRACED_POINTS_MIN = 320, POINTS_MAX = 1024, PIXELS_PER_POINT = 256, FIRST_MAX = 16 };

/* Share of the picture's samples that pilots may take. */
static const double pilots_share = 0.04;

/* Share of the samples for pilots: fewer would miss where noise is, and quiet pixels need no more. */
static const double first_share = 0.125;

static double clamp(double x, double low, double high) { return fmin(fmax(x, low), high); }

static bool is_traced(const np_frame *f) { return f->desc->integrator == NEPH_INTEGRATOR_PATH; }

static double count_view(const np_frame *f) {
  return (double)(f->view_max[0] - f->view_min[0]) * (f->view_max[1] - f->view_min[1]);
}

/* Limits a number of points to the number of pixels of a small picture. */
static unsigned limit_points(const np_frame *f, double count) {
  const double least = fmin(is_traced(f) ? TRACED_POINTS_MIN : POINTS_MIN, fmax(count_view(f), 16.0));
  return (unsigned)clamp(count, least, POINTS_MAX);
}

static neph_result fly(const np_frame *f, const np_pilot_order *order, np_pilot_points *points, np_pilots *out) {
  const neph_result result = np_pilot_points_fly(f, order, points);
  if (result) return result;
  out->exponent = measure_exponent(points, is_traced(f));
  out->noise_of_one = sqrt(get_noise(points, 0));
  out->point_count = points->count;
  out->sample_count += points->sample_count;
  return NEPH_OK;
}

/* Measures the noise of one sample a pixel. */
static neph_result measure_noise_of_one(const np_frame *f, np_pilots *out) {
  const np_pilot_order march = {.count = limit_points(f, count_view(f) / PIXELS_PER_POINT), .levels = 1};
  const np_pilot_order path = {.count = limit_points(f, 0.0), .levels = 4, .first = 2, .is_traced = true};
  np_pilot_points points;
  const neph_result result = fly(f, is_traced(f) ? &path : &march, &points, out);
  if (!result) np_pilot_points_clear(f, &points);
  return result;
}

/* Number of levels of a point, for a mean number of samples per pixel. */
static unsigned choose_levels(const np_frame *f, double samples) {
  if (is_traced(f)) return 5;
  return (unsigned)fmin(1.0 + ceil(log2(fmax(samples, 2.0))), NP_PILOT_LEVELS);
}

static void begin_rule(const np_frame *f, double samples, np_sample_rule *out) {
  const double least = f->desc->sample_count, most = f->desc->sample_count_max;
  const double first =
      fmax(floor(clamp(first_share * samples, is_traced(f) ? 2.0 : 1.0, FIRST_MAX)), fmin(least, FIRST_MAX));
  *out = (np_sample_rule){.first = (uint32_t)fmin(first, most), .max = f->desc->sample_count_max, .power = 1.0};
  out->min = (uint32_t)fmin(fmax(least, first), most);
}

static void finish_rule(np_pilot_points *points, double noise, np_pilots *out) {
  out->rule.power = 1.0 / (1.0 + out->exponent);
  out->rule.dim = points->dim;
  out->rule.usual_spread = get_noise(points, 0);
  solve_for_rule(points, noise, out);
}

/* Sets the rule for sample counts that meets the noise target. The adaptive samples are about half as many as uniform
 * ones. */
static neph_result set_rule(const np_frame *f, double noise, np_pilots *out) {
  const double even = np_pilots_predict_samples(out, noise);
  const double samples = clamp(0.5 * even, f->desc->sample_count, f->desc->sample_count_max);
  begin_rule(f, samples, &out->rule);
  np_pilot_order order = {.levels = choose_levels(f, samples), .first = out->rule.first, .is_traced = is_traced(f)};
  const double per_point = 8.0 * order.first + (double)((is_traced(f) ? 1u : 2u) << (order.levels - 1));
  order.count = limit_points(f, pilots_share * count_view(f) * samples / per_point);
  np_pilot_points points;
  const neph_result result = fly(f, &order, &points, out);
  if (result) return result;
  finish_rule(&points, noise, out);
  np_pilot_points_clear(f, &points);
  return NEPH_OK;
}

neph_result np_pilots_fly(const np_frame *f, double noise, np_pilots *out) {
  *out = (np_pilots){.exponent = 1.0};
  const neph_result result = measure_noise_of_one(f, out);
  return result || !isfinite(noise) ? result : set_rule(f, noise, out);
}
