/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/error_probes.h"

#include "core/alloc.h"
#include "frame/disk_boxes.h"
#include "image/image_error.h"

static const double dim_of_mean = 0.01;

/* Turns the frame's seed. */
static const uint64_t turn = UINT64_C(0x6a09e667f3bcc909);

/* ---- Which pixels ---- */

static size_t count_pixels(const np_frame *f) { return (size_t)f->width * f->height; }

static double compute_dim(const np_frame *f) {
  double sum = 0.0;
  for (size_t i = 0; i < count_pixels(f); i++) sum += (double)f->luminances[i].value;
  return dim_of_mean * fmax(sum / (double)count_pixels(f), 0.0);
}

/* Mean and variance of the luminance over the 3 × 3 pixels around a pixel, and the mean without it, NaN if there is no
 * other. */
typedef struct surroundings {
  double mean, variance, others;
} surroundings;

static surroundings measure_surroundings(const np_frame *f, size_t i) {
  const size_t x = i % f->width, y = i / f->width;
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (size_t v = y ? y - 1 : 0; v <= y + 1 && v < f->height; v++)
    for (size_t u = x ? x - 1 : 0; u <= x + 1 && u < f->width; u++) {
      const double value = (double)f->luminances[v * f->width + u].value;
      sum += value;
      squares += value * value;
      count += 1.0;
    }
  return (surroundings){sum / count, fmax(squares / count - sum * sum / (count * count), 0.0),
                        (sum - (double)f->luminances[i].value) / (count - 1.0)};
}

/* Limit of a guess, for dark pixels at bright edges, which few samples hit. */
static const double guess_max = 4.0;

/* Square of a pixel's relative noise, roughly; negative where the pixel cannot count. */
static double guess_noise(const np_frame *f, double dim, size_t i) {
  const np_pixel_luminance *l = &f->luminances[i];
  const surroundings around = measure_surroundings(f, i);
  if (!(around.mean > dim)) return -1.0;
  const double level = fmax((double)l->value, dim);
  return fmin(((double)l->variance + around.variance / fmax((double)l->count, 1.0)) / (level * level), guess_max);
}

static double compute_scale(const np_pixel_luminance *l, double around) {
  return np_image_weigh_scale((double)l->value, around, sqrt((double)l->variance));
}

/* Relative variance of a pixel as the spread of its samples states it; 0 where the scale is too dark to count. A rare
 * bright path is in the spread of the one pixel that it hit: relative to this pixel's value it would count as 1 at
 * most, relative to the pixels around it counts as much as it is brighter. */
static double compute_by_spread(const np_pixel_luminance *l, double around, double dim) {
  const double scale = compute_scale(l, around);
  return scale > dim ? (double)l->variance / (scale * scale) : 0.0;
}

static void add_up(const np_frame *f, np_error_probes *probes) {
  double sum = 0.0, squares = 0.0, count = 0.0, bright_count = 0.0;
  for (size_t i = 0; i < count_pixels(f); i++) {
    const surroundings around = measure_surroundings(f, i);
    const double square = compute_by_spread(&f->luminances[i], around.others, probes->dim);
    if (!(around.mean > probes->dim)) continue;
    count += 1.0;
    bright_count += compute_scale(&f->luminances[i], around.others) > probes->dim;
    sum += square;
    squares += square * square;
  }
  probes->pixel_count = count;
  probes->sum = sum;
  probes->squares = squares;
  if (count > 0.0) probes->bright_share = bright_count / count;
}

np_uncertain np_error_probes_average_spread(const np_error_probes *probes) {
  const double count = probes->pixel_count, sum = probes->sum;
  return (np_uncertain){sum / count, sqrt(fmax(probes->squares - sum * sum / count, 0.0)) / count};
}

/* Whether the disk of sun or moon reaches a pixel. */
static bool has_disk(const np_frame *f, const int at[2]) {
  np_pixel_box boxes[NP_LIGHTS_MAX];
  const unsigned count = np_frame_get_disks(f, boxes);
  for (unsigned b = 0; b < count; b++)
    if (np_pixel_box_has(&boxes[b], at)) return true;
  return false;
}

static np_error_probe start_probe(const np_frame *f, size_t i, double share) {
  const int at[2] = {f->min[0] + (int)(i % f->width), f->min[1] + (int)(i / f->width)};
  return (np_error_probe){
      .at = {at[0], at[1]},
      .has_disk = has_disk(f, at),
      .share = share,
      .count = (double)f->luminances[i].count,
      .value = (double)f->luminances[i].value,
      .around = measure_surroundings(f, i).others,
  };
}

/* Chooses pixels by systematic sampling along the rows: half of the density is proportional to the expected noise,
 * `guesses[pixel]`, and half is uniform. Pixels with a negative guess are left out. */
static void choose(const np_frame *f, unsigned count, const float *guesses, np_error_probes *probes) {
  double all = 0.0, pixels = 0.0, sum = 0.0;
  for (size_t i = 0; i < count_pixels(f); i++)
    if (guesses[i] >= 0.0f) all += (double)guesses[i], pixels += 1.0;
  np_random random = np_random_start(f->desc->seed ^ turn, (uint32_t)f->desc->frame, 0, 0, 0);
  double next = np_random_double(&random) / count;
  for (size_t i = 0; i < count_pixels(f); i++) {
    if (guesses[i] < 0.0f) continue;
    const double chance = all > 0.0 ? 0.5 / pixels + 0.5 * (double)guesses[i] / all : 1.0 / pixels;
    sum += chance;
    for (; next < sum && probes->count < count; next += 1.0 / count)
      probes->probe[probes->count++] = start_probe(f, i, 1.0 / (chance * pixels * count));
  }
}

/* The pixels whose spread states most, put after the probes in descending order. */
static void choose_outliers(const np_frame *f, unsigned count, np_error_probes *probes) {
  np_error_probe *outlier = probes->probe + probes->count;
  for (size_t i = 0; i < count_pixels(f); i++) {
    const surroundings around = measure_surroundings(f, i);
    if (!(around.mean > probes->dim)) continue;
    const double square = compute_by_spread(&f->luminances[i], around.others, probes->dim);
    if (probes->outlier_count == count && !(square > outlier[count - 1].by_spread)) continue;
    unsigned at = probes->outlier_count < count ? probes->outlier_count++ : count - 1;
    for (; at && square > outlier[at - 1].by_spread; at--) outlier[at] = outlier[at - 1];
    outlier[at] = start_probe(f, i, 0.0);
    outlier[at].is_outlier = true;
    outlier[at].by_spread = square;
  }
  probes->outlier_least = probes->outlier_count ? outlier[probes->outlier_count - 1].by_spread : (double)INFINITY;
}

/* Moves a uniform selection of the probes to the front, for the path tracer. */
static void put_traced_first(np_error_probes *probes, unsigned traced_count) {
  probes->traced_count = traced_count < probes->count ? traced_count : probes->count;
  for (unsigned i = 0; i < probes->traced_count; i++) {
    const unsigned from = (unsigned)((uint64_t)i * probes->count / probes->traced_count);
    const np_error_probe kept = probes->probe[i];
    probes->probe[i] = probes->probe[from];
    probes->probe[from] = kept;
  }
}

/* ---- Sampling ---- */

typedef void take_fn(np_error_probe *probe, unsigned seed, const np_pixel_luminance *luminance);

typedef struct probe_job {
  const np_frame *frame; /* a copy with another seed */
  uint32_t begin, count; /* samples; a count of 0: as many as the frame took */
  unsigned seed;         /* its number */
  take_fn *take;
  np_error_probe *probe;
} probe_job;

static neph_result sample_probes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const probe_job *job = user;
  for (size_t i = begin; i < end; i++) {
    np_error_probe *probe = &job->probe[i];
    np_pixel_state p = {.begin = job->begin, .next = job->begin};
    double numbers[NP_PIXEL_NUMBERS_MAX];
    const uint32_t count = job->count ? job->count : (uint32_t)probe->count;
    neph_result result = np_frame_sample_pixel(job->frame, probe->at, job->begin + count, &p, numbers);
    if (result) return result;
    const np_spread spread = np_channels_get_spread(&job->frame->channels, numbers, count);
    const np_pixel_luminance luminance = np_frame_get_luminance(job->frame, &spread);
    job->take(probe, job->seed, &luminance);
  }
  return NEPH_OK;
}

/* Samples the first probes with seeds that follow the frame's and the used ones. */
static neph_result sample_seeds(np_frame *copy, neph_render_desc *desc, unsigned first_seed, unsigned seed_count,
                                size_t probe_count, probe_job *job) {
  const uint64_t own = desc->seed;
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < seed_count && !result; k++) {
    desc->seed = own ^ np_random_mix(turn + first_seed + k);
    job->seed = k;
    result = np_parallel_for(copy->assembly->context, copy->monitor, probe_count, 1, sample_probes, job);
  }
  desc->seed = own;
  return result;
}

static void take_sample(np_error_probe *probe, unsigned seed, const np_pixel_luminance *luminance) {
  probe->by_seed[seed] = *luminance;
}

/* A pixel's light as its seeds show it, and an outlier's own value beside them. More than the pixels around have is
 * believed if it is not of one value alone, by the effective number of those that exceed them (Kish 1965,
 * section 11.7): the sun through the rim of a cloud is repeated, a rare path is not. A pixel that a disk reaches needs
 * no other: a few samples may miss a disk that is smaller than the pixel with all seeds. */
static double find_level(const np_error_probe *p, unsigned count) {
  const double base = p->around > 0.0 ? p->around : 0.0, first = p->is_outlier ? p->value : 0.0;
  double sum = first, excess = fmax(first - base, 0.0), squares = excess * excess;
  for (unsigned k = 0; k < count; k++) {
    const double value = (double)p->by_seed[k].value, more = fmax(value - base, 0.0);
    sum += value;
    excess += more;
    squares += more * more;
  }
  const double mean = sum / (p->is_outlier ? count + 1.0 : count);
  return p->has_disk || excess * excess > 1.5 * squares ? fmax(base, mean) : base;
}

/* A dark pixel beside a bright edge is as dark as its seeds say, a bright one may have met a rare path. */
static void sum_seeds(const np_error_probes *probes, np_error_probe *p, unsigned count) {
  double sum = 0.0, squares = 0.0;
  for (unsigned k = 0; k < count; k++) {
    const double value = (double)p->by_seed[k].value;
    sum += value;
    squares += value * value;
    p->half[k % 2] += 2.0 * value / count;
  }
  const double mean = sum / count;
  p->variance = fmax(squares / count - mean * mean, 0.0) * count / (count - 1.0);
  p->level = find_level(p, count);
  p->scale = fmin(np_image_weigh_scale(mean, p->around, sqrt(p->variance / count)), mean);
  if (p->level > p->around && p->variance > probes->outlier_least * p->scale * p->scale) p->scale = mean;
}

/* Relative variance of a pixel as its spread states it, where seeds have shown its mean. */
static double compute_by_seeds(const np_error_probes *probes, const np_error_probe *p, const np_pixel_luminance *l) {
  const double square = compute_by_spread(l, p->around, probes->dim);
  if (square < probes->outlier_least) return square;
  return fmin(square, compute_by_spread(l, p->level, probes->dim));
}

static void average_spreads(const np_error_probes *probes, np_error_probe *p, unsigned count) {
  p->by_spread = 0.0;
  for (unsigned k = 0; k < count; k++) p->by_spread += compute_by_seeds(probes, p, &p->by_seed[k]) / count;
}

static void restate_outliers(const np_frame *f, np_error_probes *probes) {
  for (unsigned i = probes->count; i < probes->count + probes->outlier_count; i++) {
    const np_error_probe *p = &probes->probe[i];
    const size_t at = (size_t)(p->at[1] - f->min[1]) * f->width + (size_t)(p->at[0] - f->min[0]);
    const double square = compute_by_seeds(probes, p, &f->luminances[at]);
    probes->sum += square - p->by_spread;
    probes->squares += square * square - p->by_spread * p->by_spread;
  }
}

neph_result np_error_probes_sample(const np_frame *f, unsigned seed_count, np_error_probes *probes) {
  neph_render_desc desc;
  np_frame *copy = np_frame_copy_for_luminance(f, &desc);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  np_error_probe *outliers = probes->probe + probes->count;
  probe_job job = {.frame = copy, .begin = f->desc->sample_begin, .take = take_sample, .probe = probes->probe};
  neph_result result = sample_seeds(copy, &desc, 0, seed_count, probes->count, &job);
  job.probe = outliers;
  if (!result) result = sample_seeds(copy, &desc, 0, NP_SEEDS_MAX, probes->outlier_count, &job);
  for (unsigned i = 0; i < probes->count; i++) sum_seeds(probes, &probes->probe[i], seed_count);
  for (unsigned i = 0; i < probes->count; i++) average_spreads(probes, &probes->probe[i], seed_count);
  for (unsigned i = 0; i < probes->outlier_count; i++) sum_seeds(probes, &outliers[i], NP_SEEDS_MAX);
  restate_outliers(f, probes);
  np_alloc_free(f->assembly->context, copy);
  return result;
}

static void take_traced(np_error_probe *probe, unsigned seed, const np_pixel_luminance *luminance) {
  probe->traced[seed] = (double)luminance->value;
}

/* Turns a frame into one that the path tracer samples. Air and ground come from tables, as in the march: other stages
 * are not built. */
static void make_tracer(np_frame *f) {
  f->integrate = np_integrator_get_kernels(neph_context_get_isa(f->assembly->context))->path;
  f->settings.scattering_max = f->desc->scattering_max;
  f->settings.is_split = f->settings.is_air_traced = false;
}

neph_result np_error_probes_trace(const np_frame *f, unsigned probe_count, unsigned sample_count,
                                  np_error_probes *probes) {
  neph_render_desc desc;
  np_frame *copy = np_frame_copy_for_luminance(f, &desc);
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  put_traced_first(probes, probe_count);
  make_tracer(copy);
  probe_job job = {.frame = copy, .count = sample_count, .take = take_traced, .probe = probes->probe};
  neph_result result = sample_seeds(copy, &desc, 1u << 16, 2, probes->traced_count, &job);
  np_alloc_free(f->assembly->context, copy);
  return result;
}

neph_result np_error_probes_choose(const np_frame *f, unsigned count, unsigned outlier_count, np_error_probes *out) {
  neph_context *context = f->assembly->context;
  *out = (np_error_probes){.dim = compute_dim(f), .outlier_least = (double)INFINITY};
  add_up(f, out);
  if (!(count + outlier_count) || !(out->pixel_count > 0.0)) return NEPH_OK;
  float *guesses = np_alloc(context, count_pixels(f), sizeof *guesses);
  out->probe = np_alloc(context, count + outlier_count, sizeof *out->probe);
  if (guesses && out->probe) {
    for (size_t i = 0; i < count_pixels(f); i++) guesses[i] = (float)guess_noise(f, out->dim, i);
    if (count) choose(f, count, guesses, out);
    if (outlier_count) choose_outliers(f, outlier_count, out);
  }
  np_alloc_free(context, guesses);
  return guesses && out->probe ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

void np_error_probes_clear(const np_frame *f, np_error_probes *probes) {
  np_alloc_free(f->assembly->context, probes->probe);
}
