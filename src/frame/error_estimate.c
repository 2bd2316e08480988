/* SPDX-License-Identifier: Apache-2.0 */
/* Noise from pixels sampled again, of paths corrected by the samples' spread in all pixels; bias from a model, and from
 * pixels traced. */
#include "frame/error_estimate.h"

#include "core/alloc.h"
#include "core/text.h"
#include "core/units.h"
#include "frame/bias_measure.h"
#include "image/image_private.h"
#include "plan/stage_rules.h"

static const double normal_quantile_975 = 1.959963984540054;

static const neph_bounded unknown = {(double)NAN, (double)NAN, (double)NAN};

/* Root of a square whose logarithm is spread normally. */
static neph_bounded take_root(np_uncertain square) {
  if (!(square.value > 0.0))
    return (neph_bounded){square.value == 0.0 ? 0.0 : (double)NAN, 0.0, sqrt(square.deviation)};
  const double factor = exp(0.5 * normal_quantile_975 * square.deviation / square.value), root = sqrt(square.value);
  return (neph_bounded){root, root / factor, root * factor};
}

/* ---- Noise ---- */

/* Variance of stratified samples relative to independent ones. Paths: their many dimensions are not filled, 0.58 to
 * 0.99 is left in five scenes. Marches: 0.26 to 0.7 in 14. */
static const np_uncertain march_evenness = {0.55, 0.4}, path_evenness = {0.85, 0.6};

enum { PROBES_MIN = 8 };

static double get_mean(const np_error_probe *p) { return 0.5 * (p->half[0] + p->half[1]); }

/* Σ share·value over Σ share, over the probes that count, and its standard deviation. */
typedef double measure_fn(const np_error_probe *p);

static np_uncertain average(const np_error_probes *probes, unsigned count, measure_fn *measure) {
  double sum = 0.0, shares = 0.0, residual2 = 0.0, n = 0.0;
  for (unsigned i = 0; i < count; i++) {
    const np_error_probe *p = &probes->probe[i];
    if (!(get_mean(p) > probes->dim)) continue;
    sum += p->share * measure(p);
    shares += p->share;
    n += 1.0;
  }
  const double mean = shares > 0.0 ? sum / shares : (double)NAN;
  for (unsigned i = 0; i < count; i++) {
    const np_error_probe *p = &probes->probe[i];
    if (get_mean(p) > probes->dim) residual2 += pow(p->share * (measure(p) - mean) / shares, 2.0);
  }
  return (np_uncertain){mean, sqrt(residual2 * n / fmax(n - 1.0, 1.0))};
}

/* Means over pixels that may count, by the probes. */
typedef struct probe_means {
  double variance, by_spread; /* relative variance over seeds, and as the spread of samples states it */
  double bright_share;        /* share of pixels whose scale is not too dark to count */
} probe_means;

static probe_means get_probe(const np_error_probes *probes, const np_error_probe *p) {
  const bool is_bright = p->scale > probes->dim;
  return (probe_means){is_bright ? p->variance / (p->scale * p->scale) : 0.0, p->by_spread, is_bright ? 1.0 : 0.0};
}

static probe_means average_probes(const np_error_probes *probes) {
  probe_means sum = {0.0, 0.0, 0.0};
  double shares = 0.0;
  for (unsigned i = 0; i < probes->count; i++) {
    const np_error_probe *p = &probes->probe[i];
    const probe_means own = get_probe(probes, p);
    shares += p->share;
    sum.variance += p->share * own.variance;
    sum.by_spread += p->share * own.by_spread;
    sum.bright_share += p->share * own.bright_share;
  }
  return (probe_means){sum.variance / shares, sum.by_spread / shares, sum.bright_share / shares};
}

/* Probes show the share of variance that stratification leaves, and how dark a pixel beside a bright edge is; all
 * pixels together meet rare bright paths that probes miss. So the estimate is the mean over the probes, and the same
 * share of what the spreads of all pixels state beyond those of the probes' seeds (difference estimator: Cochran 1977,
 * eq. 7.11). */
static np_uncertain measure_noise(const np_error_probes *probes) {
  const probe_means mean = average_probes(probes);
  const double n = probes->count, left = mean.by_spread > 0.0 ? fmin(mean.variance / mean.by_spread, 1.0) : 0.0;
  double residual2 = 0.0;
  for (unsigned i = 0; i < probes->count; i++) {
    const probe_means own = get_probe(probes, &probes->probe[i]);
    const double residual = own.variance - mean.variance - left * (own.by_spread - mean.by_spread);
    residual2 += pow(probes->probe[i].share * residual, 2.0);
  }
  const np_uncertain by_spread = np_error_probes_average_spread(probes);
  const double value = mean.variance + left * (by_spread.value - mean.by_spread);
  const double deviation = hypot(sqrt(residual2 * n / (n - 1.0)), left * by_spread.deviation);
  return (np_uncertain){fmax(value, 0.0) / mean.bright_share, deviation / mean.bright_share};
}

static double get_noise(const np_error_probe *p) { return p->variance / (get_mean(p) * get_mean(p)); }

/* Marches have no rare bright paths, and few samples: at the rim of the sun's disk, where their spread is large and the
 * pixels around are dark, the spread of all pixels would state many times the noise. */
static neph_bounded estimate_noise(const np_error_probes *probes, bool is_path, double samples) {
  const np_uncertain *usual = is_path ? &path_evenness : &march_evenness;
  if (probes->count >= PROBES_MIN)
    return take_root(is_path ? measure_noise(probes) : average(probes, probes->count, get_noise));
  if (samples < 2.0) return unknown; /* single samples have no spread */
  const np_uncertain by_spread = np_error_probes_average_spread(probes);
  const double value = by_spread.value / probes->bright_share, deviation = by_spread.deviation / probes->bright_share;
  return take_root((np_uncertain){usual->value * value, hypot(usual->deviation * value, usual->value * deviation)});
}

/* ---- Bias ---- */

/* Mean of (P₁ − M₁)(P₂ − M₂)/T², P by the tracer and M by the frame: the noise of the four is independent and does
 * not stay. */
static double get_bias(const np_error_probe *p) {
  const double mean = 0.5 * (get_mean(p) + 0.5 * (p->traced[0] + p->traced[1]));
  return (p->traced[0] - p->half[0]) * (p->traced[1] - p->half[1]) / (mean * mean);
}

/* Share of the scattering within a degree from which on a phase function has a peak: lobes of g = 0.85 have 0.006,
 * droplets 0.2 to 0.35, crystals about a half. */
static const double peak_share_least = 0.4;

/* Light that the tracer may lack without rare paths, relative to all, and the mean square over pixels: 10 and 25 % of
 * pixels under an altostratus of depth 3.4, whose mean over many more paths is that of the march. */
static const double unmet_shift = 0.1, unmet_square = 0.06;

enum { PEAK_STEPS = 64 };

/* Relative difference of the tracer from the frame: its mean over the picture is the part of the bias that has one
 * sign, and is known to a percent where the square of a pixel's is not. */
static double get_shift(const np_error_probe *p) { return 0.5 * (p->traced[0] + p->traced[1]) / get_mean(p) - 1.0; }

static neph_bounded add_squares(const neph_bounded *a, const neph_bounded *b) {
  if (isnan(a->value)) return unknown;
  const double square = a->value * a->value + b->value * b->value;
  const double more = hypot(a->max * a->max - a->value * a->value, b->max * b->max - b->value * b->value);
  const double less = hypot(a->value * a->value - a->min * a->min, b->value * b->value - b->min * b->min);
  return (neph_bounded){sqrt(square), sqrt(fmax(square - less, 0.0)), sqrt(square + more)};
}

/* Share of the scattering within a degree, in the middle band: by steps even in the versine's logarithm. */
static double compute_peak(const np_phase *phase) {
  const double low = log(1e-10), high = log(1.5e-4);
  double sum = 0.0;
  for (int n = 0; n < PEAK_STEPS; n++) {
    const double versine = exp(low + (high - low) * (n + 0.5) / PEAK_STEPS);
    sum += 2.0 * NP_PI * versine * (double)np_phase_eval_bands(phase, (float)versine).band[1];
  }
  return sum * (high - low) / PEAK_STEPS;
}

static bool has_peak(const np_frame *f) {
  const np_instances *clouds = &f->assembly->packets[0].lights[0].world.clouds;
  bool has = false;
  for (unsigned i = 0; i < clouds->count; i++) has = has || compute_peak(&clouds->at[i].phase) > peak_share_least;
  return has;
}

/* A peak sends much of the sunlight on within a degree. In thin clouds the paths that meet it are a tenth of all light
 * and so bright that a few thousand paths hold one or none: without it the tracer is too dark. So a tracer that is
 * darker than the march is known to no more than that. */
static void doubt_darkness(np_bias_measure *measured) {
  if (!(measured->shift.deviation > 0.0) || measured->shift.value >= 0.0) return;
  measured->shift.deviation = hypot(measured->shift.deviation, unmet_shift);
  measured->square.deviation = hypot(measured->square.deviation, unmet_square);
}

/* A measure that says less than the model is of no weight; without one the model is alone. */
static neph_bounded estimate_bias(const np_frame *f, const np_bias_model *model, const np_error_probes *probes,
                                  bool *out_is_measured) {
  neph_context *context = f->assembly->context;
  *out_is_measured = false;
  const neph_bounded shared = {model->shared, 0.5 * model->shared, 2.0 * model->shared};
  if (!(model->bias > 0.0)) return shared;
  np_bias_measure measured = {{0.0, 0.0}, {0.0, 0.0}};
  if (probes->traced_count >= PROBES_MIN)
    measured = (np_bias_measure){average(probes, probes->traced_count, get_bias),
                                 average(probes, probes->traced_count, get_shift)};
  if (has_peak(f)) doubt_darkness(&measured);
  *out_is_measured = measured.shift.deviation > 0.0 && measured.shift.deviation < 0.5 * model->bias;
  np_log(context, NEPH_LOG_DEBUG, "bias by the tracer: mean %.2g ± %.2g, square %.2g ± %.2g, of %u pixels; model %.2g",
         measured.shift.value, measured.shift.deviation, measured.square.value, measured.square.deviation,
         probes->traced_count, model->bias);
  const neph_bounded own = np_bias_combine(model, &measured);
  return add_squares(&own, &shared);
}

/* ---- Both ---- */

/* Samples for each predicted second of the frame that the march takes again, some 2 % of its time, and the tracer, some
 * 4 %; the tracer's samples from which it shows anything, and the time of frames that can pay for them. */
static const double samples_per_s = 1100.0, traced_per_s = 600.0, traced_least = 2400.0, traced_from_s = 2.0;

/* Bound on samples of probes as a share of the frame's own samples, in frames whose time goes into samples. */
static const double samples_share = 0.02;

enum {
  PROBES_MAX = 256,
  OUTLIERS_MIN = 4,
  OUTLIERS_MAX = 16,
  TRACED_PROBES_MAX = 64,
  TRACED_SAMPLES_PER_PROBE = 60,
  SEEDS_MIN = 8
};

/* Number of seeds, an even one, for estimating a pixel's variance and mean from `samples` samples, at least 1. */
static unsigned count_seeds(double samples) {
  return samples * SEEDS_MIN >= NP_SEEDS_MAX ? SEEDS_MIN : (unsigned)(NP_SEEDS_MAX / samples) / 2 * 2;
}

static double get_mean_samples(const np_frame *f) {
  double sum = 0.0;
  const size_t count = (size_t)f->width * f->height;
  for (size_t i = 0; i < count; i++) sum += (double)f->luminances[i].count;
  return fmax(sum / (double)count, 1.0);
}

/* Fewer probes where they have more than `allowed` samples for a seed: with a target error the noisy pixels, which are
 * chosen more often, have more than the mean. */
static neph_result limit_probes(const np_frame *f, double allowed, np_error_probes *probes) {
  double samples = 0.0;
  for (unsigned i = 0; i < probes->count; i++) samples += probes->probe[i].count;
  if (!np_frame_has_target(f) || samples <= allowed) return NEPH_OK;
  const double count = fmax(floor(probes->count * allowed / samples), PROBES_MIN);
  const unsigned outliers = probes->outlier_count;
  np_error_probes_clear(f, probes);
  return np_error_probes_choose(f, (unsigned)count, outliers, probes);
}

/* Share of the whole picture's samples that are of this part. */
static double get_share(const np_plan *plan) {
  const neph_render_desc *d = &plan->request.desc;
  const double whole = (double)(plan->request.whole_max[0] - plan->request.whole_min[0]) *
                       (plan->request.whole_max[1] - plan->request.whole_min[1]);
  return (double)np_request_count_pixels(&plan->request) / whole * (d->sample_end - d->sample_begin) / d->sample_count;
}

/* Predicted time of the frame, in a draft without what its edits reuse: each is probed. A part has a share of all that
 * the parts have in common: together they are probed as often as the whole. */
static double predict_time(const np_plan *plan) {
  return plan->forecast.constant_s - (1.0 - get_share(plan)) * plan->forecast.constant_common_s;
}

/* Outliers, which have NP_SEEDS_MAX seeds each, for a quarter of the samples that probes are allowed. A disk of the sun
 * that is smaller than a pixel lies in up to four. */
static unsigned count_outliers(const np_frame *f, double allowed, double samples) {
  if (f->desc->integrator != NEPH_INTEGRATOR_PATH || f->is_cut || samples < 2.0) return 0;
  return (unsigned)fmin(fmax(0.25 * allowed / (NP_SEEDS_MAX * samples), OUTLIERS_MIN), OUTLIERS_MAX);
}

static neph_result sample_probes(const np_frame *f, const np_plan *plan, np_error_probes *out) {
  const double samples = get_mean_samples(f), pixels = (double)f->width * f->height;
  const double all_s = predict_time(plan) * (f->desc->integrator == NEPH_INTEGRATOR_PATH ? 0.3 : 1.0);
  const double allowed = samples_per_s * all_s + samples_share * pixels * samples;
  const unsigned seeds = count_seeds(samples);
  const double count = allowed / (seeds * samples), share = get_share(plan);
  const bool is_known = count >= share * PROBES_MIN && !f->is_cut;
  const double chosen = is_known ? fmax(fmin(count, share * PROBES_MAX), PROBES_MIN) : 0.0;
  neph_result result = np_error_probes_choose(f, (unsigned)chosen, count_outliers(f, allowed, samples), out);
  if (!result) result = limit_probes(f, allowed / seeds, out);
  return result || !(out->count + out->outlier_count) ? result : np_error_probes_sample(f, seeds, out);
}

/* Traces some of the probes by the path tracer. The results are dropped if tracing takes more than a quarter of the
 * frame's time. */
static neph_result trace_probes(const np_frame *f, const np_plan *plan, np_error_probes *probes) {
  const double time_s = predict_time(plan), least = time_s >= traced_from_s ? get_share(plan) * traced_least : 0.0;
  const double samples = fmax(traced_per_s * time_s, least) / plan->decisions.packet_count;
  const double most = fmax(get_share(plan) * TRACED_PROBES_MAX, PROBES_MIN);
  const double count = fmin(fmin(samples / TRACED_SAMPLES_PER_PROBE, most), probes->count);
  if (f->desc->integrator == NEPH_INTEGRATOR_PATH || count < PROBES_MIN) return NEPH_OK;
  np_monitor_begin_budget(f->monitor, fmin(1.25 * np_monitor_get_seconds(f->monitor), f->assembly->schedule.limit_s));
  neph_result result = np_error_probes_trace(f, (unsigned)count, (unsigned)(0.5 * samples / floor(count)), probes);
  const bool is_cut = np_monitor_end_budget(f->monitor);
  if (is_cut) probes->traced_count = 0;
  return is_cut && result == NEPH_ERROR_CANCELLED ? NEPH_OK : result;
}

neph_result np_frame_estimate_error(const np_frame *f, const np_plan *plan, np_frame_error *out) {
  const bool is_path = f->desc->integrator == NEPH_INTEGRATOR_PATH;
  *out = (np_frame_error){unknown, unknown, unknown, false};
  np_error_probes probes;
  neph_result result = sample_probes(f, plan, &probes);
  /* A first picture is shown for a moment: the model alone states its bias. */
  if (!result && !plan->request.takes_near) result = trace_probes(f, plan, &probes);
  if (!result && probes.pixel_count > 0.0) {
    const np_bias_model model = np_bias_model_make(f, plan);
    out->noise = estimate_noise(&probes, is_path, get_mean_samples(f));
    out->bias = estimate_bias(f, &model, &probes, &out->is_bias_measured);
    out->total = add_squares(&out->noise, &out->bias);
  }
  np_error_probes_clear(f, &probes);
  return result;
}

/* ---- Header ---- */

static neph_result write_bounded(neph_image *image, const char *name, const neph_bounded *figure) {
  const struct {
    const char *ending;
    double value;
  } parts[] = {{"", figure->value}, {"Min", figure->min}, {"Max", figure->max}};
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < sizeof parts / sizeof *parts && !result; i++) {
    char full[32];
    np_print(full, sizeof full, "%s%s", name, parts[i].ending);
    if (isfinite(parts[i].value)) result = np_image_set_real(image, full, parts[i].value);
  }
  return result;
}

neph_result np_frame_error_write(const np_frame_error *error, neph_image *image) {
  neph_result result = write_bounded(image, "nephos:error", &error->total);
  if (!result) result = write_bounded(image, "nephos:noise", &error->noise);
  if (!result) result = write_bounded(image, "nephos:bias", &error->bias);
  if (result || isnan(error->bias.value)) return result;
  return neph_image_set_attribute(image, "nephos:biasSource", error->is_bias_measured ? "measured" : "model");
}
