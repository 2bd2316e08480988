/* SPDX-License-Identifier: Apache-2.0 */
#include "render/pilots.h"

#include "core/alloc.h"

/* Turns the frame's seed, apart from that of the error's probes. */
static const uint64_t turn = UINT64_C(0xbb67ae8584caa73b);

/* Seeds by which a point shows the variance of its pixel's mean, and one more for the pilots around it. */
enum { SEEDS = 2 };

enum { LEVELS = 6, NEIGHBOURS = 9, MIDDLE = 4 };

/* A pixel of the lattice. */
typedef struct point {
  int at[2];
  np_pilot around[NEIGHBOURS];
  double sum[LEVELS], squares[LEVELS]; /* over seeds, of the means of 2ˡ samples */
  double mean;
} point;

typedef struct lattice {
  const np_frame *frame; /* a copy with another seed */
  const np_frame *whole;
  point *points;
  unsigned count;
  unsigned levels; /* the last has 2^(levels − 1) samples */
  uint32_t first;  /* samples of each pilot around a point; 0: none are flown */
  double dim;      /* a hundredth of the mean luminance */
} lattice;

/* ---- Sampling ---- */

static double get_size(const np_frame *f, int axis) { return (double)(f->view_max[axis] - f->view_min[axis]); }

/* Points of the plastic number, as those of a pixel's samples, turned by seed and frame. */
static void place_points(lattice *l) {
  static const double step[2] = {0.7548776662466927, 0.5698402909980532};
  const np_frame *f = l->whole;
  np_random random = np_random_start(f->desc->seed ^ turn, (uint32_t)f->desc->frame, 0, 0, 0);
  const double offset[2] = {np_random_double(&random), np_random_double(&random)};
  for (unsigned i = 0; i < l->count; i++)
    for (int a = 0; a < 2; a++) {
      const double x = offset[a] + step[a] * i;
      l->points[i].at[a] = f->view_min[a] + (int)((x - floor(x)) * get_size(f, a));
    }
}

static neph_result sample_middle(const lattice *l, point *p) {
  np_pixel_state state = {.next = 0};
  double numbers[NP_PIXEL_NUMBERS_MAX];
  for (unsigned level = 0; level < l->levels; level++) {
    neph_result result = np_frame_sample_pixel(l->frame, p->at, 1u << level, &state, numbers);
    if (result) return result;
    const np_spread spread = np_channels_get_spread(&l->frame->channels, numbers, state.next);
    const double value = (double)np_frame_get_luminance(l->frame, &spread).value;
    p->sum[level] += value;
    p->squares[level] += value * value;
  }
  return NEPH_OK;
}

static neph_result sample_middles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const lattice *l = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++) result = sample_middle(l, &l->points[i]);
  return result;
}

static neph_result sample_around(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const lattice *l = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++)
    for (int k = 0; k < NEIGHBOURS && !result; k++) {
      point *p = &l->points[i];
      const int at[2] = {p->at[0] + k % 3 - 1, p->at[1] + k / 3 - 1};
      if (k != MIDDLE && np_frame_is_in_view(l->whole, at))
        result = np_frame_fly_pilot(l->frame, at, l->first, &p->around[k]);
    }
  return result;
}

static neph_result sample_lattice(lattice *l) {
  neph_render_desc desc;
  np_frame *copy = np_frame_copy_for_luminance(l->whole, &desc);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  const uint64_t own = desc.seed;
  neph_result result = NEPH_OK;
  l->frame = copy;
  for (unsigned k = 0; k <= SEEDS && !result; k++) {
    desc.seed = own ^ np_random_mix(turn + 1 + k);
    if (k < SEEDS)
      result = np_parallel_for(copy->assembly->context, copy->monitor, l->count, 1, sample_middles, l);
    else if (l->first)
      result = np_parallel_for(copy->assembly->context, copy->monitor, l->count, 1, sample_around, l);
  }
  np_alloc_free(copy->assembly->context, copy);
  return result;
}

/* From sums to variances of the means, in their place. */
static void compute_variances(lattice *l) {
  double sum = 0.0;
  for (unsigned i = 0; i < l->count; i++) {
    point *p = &l->points[i];
    p->mean = p->sum[l->levels - 1] / SEEDS;
    sum += p->mean;
    for (unsigned level = 0; level < l->levels; level++)
      p->squares[level] = fmax(p->squares[level] - p->sum[level] * p->sum[level] / SEEDS, 0.0) / (double)(SEEDS - 1);
  }
  l->dim = fmax(0.01 * sum / l->count, 0.0);
}

static neph_result fly(const np_frame *f, unsigned count, unsigned levels, uint32_t first, lattice *out) {
  *out = (lattice){.whole = f, .count = count, .levels = levels, .first = first};
  out->points = np_alloc(f->assembly->context, count, sizeof *out->points);
  if (!out->points) return NEPH_ERROR_OUT_OF_MEMORY;
  place_points(out);
  const neph_result result = sample_lattice(out);
  if (!result) compute_variances(out);
  return result;
}

/* ---- Noise of the picture ---- */

/* Mean of Var/T² over the points that count, each with `1 << level` samples. */
static double average(const lattice *l, unsigned level) {
  double sum = 0.0, count = 0.0;
  for (unsigned i = 0; i < l->count; i++) {
    const point *p = &l->points[i];
    if (!(p->mean > l->dim)) continue;
    sum += p->squares[level] / (p->mean * p->mean);
    count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

/* Exponents of independent samples, and of the best that points in two dimensions may do for an edge. */
static const double exponent_min = 1.0, exponent_max = 2.0;

/* A tracer's samples are independent but for their places in the pixel, which few of them have evened out. */
static double measure_exponent(const lattice *l, bool is_traced) {
  const double one = average(l, 0), all = average(l, l->levels - 1);
  if (is_traced || l->levels < 2 || !(one > 0.0) || !(all > 0.0)) return is_traced ? exponent_min : 1.5;
  return fmin(fmax(log2(one / all) / (l->levels - 1), exponent_min), exponent_max);
}

/* Variance of a point's mean of `count` samples: linear in their reciprocal between two levels. */
static double get_variance(const lattice *l, const point *p, double count, double exponent) {
  const unsigned last = l->levels - 1;
  const unsigned level = (unsigned)fmin(floor(log2(count)), last);
  const double here = p->squares[level], most = (double)(1u << level);
  if (level == last) return here * pow(most / count, exponent);
  const double share = 2.0 * most / count - 1.0; /* 1 at this level, 0 at the next */
  return share * here + (1.0 - share) * p->squares[level + 1];
}

/* Noise² by the rule, and the mean number of samples. */
static double apply_rule(const lattice *l, const np_sample_rule *rule, double exponent, double *out_samples) {
  double sum = 0.0, counted = 0.0, samples = 0.0;
  for (unsigned i = 0; i < l->count; i++) {
    const point *p = &l->points[i];
    const double n = np_sample_rule_count(rule, np_sample_rule_estimate_spread(rule, &p->around[MIDDLE], 3));
    samples += n;
    if (!(p->mean > l->dim)) continue;
    sum += get_variance(l, p, n, exponent) / (p->mean * p->mean);
    counted += 1.0;
  }
  *out_samples = samples / l->count;
  return counted > 0.0 ? sum / counted : 0.0;
}

enum { GAIN_STEPS = 48 };

/* Least gain that leaves the noise at most as large as it is to be: noise falls as the gain grows. */
static void solve_for_gain(const lattice *l, double noise, np_pilots *out) {
  double low = 0.0, high = log(1e18);
  out->noise = sqrt(apply_rule(l, &out->rule, out->exponent, &out->samples));
  if (out->noise <= noise) return;
  for (int i = 0; i < GAIN_STEPS; i++) {
    const double middle = 0.5 * (low + high);
    out->rule.gain = exp(middle);
    *(apply_rule(l, &out->rule, out->exponent, &out->samples) > noise * noise ? &low : &high) = middle;
  }
  out->rule.gain = exp(high);
  out->noise = sqrt(apply_rule(l, &out->rule, out->exponent, &out->samples));
}

double np_pilots_predict_samples(const np_pilots *pilots, double noise) {
  return fmax(pow(pilots->noise_of_one / noise, 2.0 / pilots->exponent), 1.0);
}

/* ---- Size of the lattice ---- */

enum { POINTS_MIN = 256, POINTS_MAX = 1024, FIRST_POINTS_MAX = 512, PIXELS_PER_POINT = 512, FIRST_MAX = 16 };

/* Share of the picture's samples that pilots may take. */
static const double pilots_share = 0.04;

/* Pilots take an eighth of the pixels' samples: fewer tell less of where noise is, and quiet pixels need no more. */
static const double first_share = 0.125;

static double clamp(double x, double low, double high) { return fmin(fmax(x, low), high); }

static bool is_traced(const np_frame *f) { return f->desc->integrator == NEPH_INTEGRATOR_PATH; }

static double count_view(const np_frame *f) { return get_size(f, 0) * get_size(f, 1); }

/* A first look: the noise of one sample. */
static neph_result look(const np_frame *f, np_pilots *out) {
  lattice l;
  const unsigned count = (unsigned)clamp(count_view(f) / PIXELS_PER_POINT, POINTS_MIN, FIRST_POINTS_MAX);
  const unsigned levels = is_traced(f) ? 3 : 1;
  neph_result result = fly(f, count, levels, 0, &l);
  if (!result) {
    out->exponent = measure_exponent(&l, is_traced(f));
    out->noise_of_one = sqrt(average(&l, 0));
    out->sample_count += (uint64_t)count * SEEDS << (levels - 1);
    out->point_count = count;
  }
  np_alloc_free(f->assembly->context, l.points);
  return result;
}

/* Levels that hold so many samples. */
static unsigned choose_levels(const np_frame *f, double samples) {
  const unsigned levels = 1 + (unsigned)ceil(log2(clamp(samples, 2.0, is_traced(f) ? 16.0 : 32.0)));
  return levels < LEVELS ? levels : LEVELS;
}

/* The picture's samples about half as many as for an even number in each pixel. */
static neph_result set_rule(const np_frame *f, double noise, np_pilots *out) {
  const double most = f->desc->sample_count_max;
  const double samples = clamp(0.5 * np_pilots_predict_samples(out, noise), f->desc->sample_count, most);
  const double first = floor(clamp(first_share * samples, 1.0, FIRST_MAX)), least = f->desc->sample_count;
  out->rule.first = (uint32_t)fmin(fmax(first, fmin(least, FIRST_MAX)), most);
  out->rule.min = (uint32_t)fmin(fmax(least, out->rule.first), most);
  out->rule.max = f->desc->sample_count_max;
  lattice l;
  const unsigned levels = choose_levels(f, samples);
  const double per_point = 8.0 * out->rule.first + (double)((unsigned)SEEDS << (levels - 1));
  const unsigned count =
      (unsigned)clamp(pilots_share * count_view(f) * samples / per_point, out->point_count, POINTS_MAX);
  neph_result result = fly(f, count, levels, out->rule.first, &l);
  if (!result) {
    out->exponent = measure_exponent(&l, is_traced(f));
    out->noise_of_one = sqrt(average(&l, 0));
    out->rule.power = 1.0 / (1.0 + out->exponent);
    out->rule.dim = l.dim;
    out->rule.usual_spread = average(&l, 0);
    out->sample_count += (uint64_t)(count * per_point);
    out->point_count = count;
    solve_for_gain(&l, noise, out);
  }
  np_alloc_free(f->assembly->context, l.points);
  return result;
}

neph_result np_pilots_fly(const np_frame *f, double noise, np_pilots *out) {
  *out = (np_pilots){.exponent = 1.0};
  const neph_result result = look(f, out);
  return result || !isfinite(noise) ? result : set_rule(f, noise, out);
}
