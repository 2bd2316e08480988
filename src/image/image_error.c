/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture, its noise and its bias apart (docs/error.md): means over pixels of squares relative to the
 * reference, each with bounds from the spread of 8×8 blocks, which are taken as independent. */
#include "image/image_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/text.h"
#include "image/color_space.h"

enum { BLOCK_PIXELS = 8, AROUND_PIXELS = 2 };

static const double dim_of_mean = 0.01;
static const double normal_quantile_975 = 1.959963984540054; /* two-sided 95 % interval */

static const neph_bounded unknown = {(double)NAN, (double)NAN, (double)NAN};

/* ---- Luminance ---- */

/* Channels of a luminance and their weights. */
typedef struct luminance {
  unsigned count;
  const unsigned *indices; /* channels of the reference */
  double weights[3];       /* weights of R, G, B; other channels are averaged */
} luminance;

static bool is_colour(const neph_image *image, const luminance *l) {
  const char *space = neph_image_get_attribute(image, "nephos:colorSpace");
  const bool is_of_bands = space && !strcmp(space, np_color_space_get_name(NP_COLOR_BANDS));
  return l->count == 3 && !strcmp(image->channels[l->indices[0]].name, "R") && !is_of_bands;
}

/* Channels of a luminance. Primaries are Rec.709 where the header names none, as in OpenEXR. */
static luminance choose_luminance(const neph_image *reference, unsigned *indices) {
  luminance l = {.count = np_image_choose_channels(reference, indices), .indices = indices};
  if (!is_colour(reference, &l)) return l;
  const bool is_named = reference->header.has_chromaticities;
  const float *own = is_named ? reference->header.chromaticities : np_color_space_get_chromaticities(NP_COLOR_REC709);
  if (!np_color_space_get_luminances(own, l.weights)) l.weights[0] = 0.0;
  return l;
}

static double get_weight(const luminance *l, unsigned c) {
  const bool is_weighted = l->count == 3 && l->weights[0] + l->weights[1] + l->weights[2] > 0.0;
  return is_weighted ? l->weights[c] : 1.0 / l->count;
}

const float *np_image_get_prefixed(const neph_image *image, const char *prefix, const char *name) {
  const size_t length = strlen(prefix);
  for (unsigned c = 0; c < image->channel_count; c++) {
    const np_image_channel *channel = &image->channels[c];
    if (!strncmp(channel->name, prefix, length) && !strcmp(channel->name + length, name)) return channel->values;
  }
  return NULL;
}

/* Adds weighted planes of the channels with a prefix. False where one is missing. */
static bool add_planes(const neph_image *image, const neph_image *reference, const luminance *l, const char *prefix,
                       double *out) {
  const size_t count = (size_t)reference->width * reference->height;
  for (unsigned c = 0; c < l->count; c++) {
    const float *values = np_image_get_prefixed(image, prefix, reference->channels[l->indices[c]].name);
    if (!values) return false;
    const double weight = get_weight(l, c);
    for (size_t i = 0; i < count; i++) out[i] += weight * (double)values[i];
  }
  return true;
}

/* ---- Figures that the header states ---- */

static double get_number(const neph_image *image, const char *name, const char *ending) {
  char full[32];
  np_print(full, sizeof full, "%s%s", name, ending);
  const char *text = neph_image_get_attribute(image, full);
  return text ? strtod(text, NULL) : (double)NAN;
}

static neph_bounded get_bounded(const neph_image *image, const char *name) {
  return (neph_bounded){get_number(image, name, ""), get_number(image, name, "Min"), get_number(image, name, "Max")};
}

static neph_bias_source get_bias_source(const neph_image *image) {
  const char *source = neph_image_get_attribute(image, "nephos:biasSource");
  if (!source) return NEPH_BIAS_UNKNOWN;
  return strcmp(source, "measured") ? NEPH_BIAS_BY_MODEL : NEPH_BIAS_MEASURED;
}

neph_result neph_image_get_error(const neph_image *image, neph_image_error *out_error) {
  if (NP_LACKS(NP_CONTEXT_OF(image), out_error)) return NEPH_ERROR_INVALID_ARGUMENT;
  const neph_image_error error = {.struct_size = sizeof error,
                                  .error = get_bounded(image, "nephos:error"),
                                  .noise = get_bounded(image, "nephos:noise"),
                                  .bias = get_bounded(image, "nephos:bias"),
                                  .bias_source = get_bias_source(image)};
  return np_desc_write(image->context, "neph_image_error", &error, sizeof error, out_error);
}

neph_bounded np_image_get_stated_noise(const neph_image *image) { return get_bounded(image, "nephos:noise"); }

/* Mean of squares, and variance of the mean. */
typedef struct moments {
  double mean, variance;
} moments;

static bool get_stated_noise(const neph_image *image, moments *out) {
  const neph_bounded noise = np_image_get_stated_noise(image);
  const double square = noise.value * noise.value;
  *out = (moments){square, pow((noise.max * noise.max - square) / normal_quantile_975, 2.0)};
  return isfinite(out->mean) && isfinite(out->variance);
}

/* ---- Pixels ---- */

/* Luminances, and their standard errors where the pictures state them, otherwise NULL. The channels of a pixel share
 * their samples, so that their standard errors add up. */
typedef struct planes {
  neph_context *context;
  unsigned width, height;
  double *picture, *second, *reference, *picture_error, *reference_error;
  double *scale; /* scale of relative differences */
  neph_noise_source source;
  double noise_share;                          /* noise of the reference from its header; 0 with other sources */
  double picture_variance, reference_variance; /* variances of the squared noises from the headers' bounds; 0: not
                                                  used */
  double dim;                                  /* threshold below which pixels are left out */
} planes;

static void free_planes(planes *p) {
  double *const all[] = {p->picture, p->second, p->reference, p->picture_error, p->reference_error, p->scale};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) np_alloc_free(p->context, all[i]);
}

static neph_result fill_plane(const planes *p, const neph_image *image, const neph_image *reference, const luminance *l,
                              const char *prefix, double **out) {
  *out = np_alloc(p->context, (size_t)p->width * p->height, sizeof **out);
  if (!*out) return NEPH_ERROR_OUT_OF_MEMORY;
  if (add_planes(image, reference, l, prefix, *out)) return NEPH_OK;
  np_alloc_free(p->context, *out);
  *out = NULL;
  return NEPH_OK;
}

/* ---- Scale ---- */

/* Mean of the eight neighbours of a pixel; NaN without any. */
static double average_around(const planes *p, unsigned x, unsigned y) {
  const unsigned left = x > AROUND_PIXELS ? x - AROUND_PIXELS : 0, top = y > AROUND_PIXELS ? y - AROUND_PIXELS : 0;
  double sum = 0.0, count = 0.0;
  for (unsigned v = top; v <= y + AROUND_PIXELS && v < p->height; v++)
    for (unsigned u = left; u <= x + AROUND_PIXELS && u < p->width; u++) {
      const double value = p->reference[(size_t)v * p->width + u];
      if (!isfinite(value) || (u == x && v == y)) continue;
      sum += value;
      count += 1.0;
    }
  return sum / count;
}

/* Standard error of a pixel of the reference whose luminance is about `mean`. */
static double get_reference_error(const planes *p, size_t i, double mean) {
  if (p->source == NEPH_NOISE_BY_HEADER) return p->noise_share * mean;
  return p->reference_error && isfinite(p->reference_error[i]) ? p->reference_error[i] : 0.0;
}

/* Noise at which a pixel and the mean around it have equal weight in the scale. */
static const double half_weight_noise = 0.05;

/* Standard errors by which an isolated bright pixel exceeds the pixels around it. */
static const double highlight_errors = 4.0;

double np_image_weigh_scale(double own, double around, double error) {
  if (!(around > 0.0)) return own;
  const double noise = error / around / half_weight_noise, weight = 1.0 / (1.0 + noise * noise);
  return fmax(weight * own + (1.0 - weight) * around, own - highlight_errors * error);
}

static double compute_scale(const planes *p, unsigned x, unsigned y) {
  const size_t i = (size_t)y * p->width + x;
  const double own = p->reference[i];
  if (p->source == NEPH_NOISE_UNKNOWN || !isfinite(own)) return own;
  const double around = average_around(p, x, y);
  return np_image_weigh_scale(own, around, get_reference_error(p, i, around));
}

static neph_result fill_scale(planes *p) {
  p->scale = np_alloc(p->context, (size_t)p->width * p->height, sizeof *p->scale);
  for (unsigned y = 0; p->scale && y < p->height; y++)
    for (unsigned x = 0; x < p->width; x++) p->scale[(size_t)y * p->width + x] = compute_scale(p, x, y);
  return p->scale ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Whether the pictures are the same: then they share all noise, and the differences have none. */
static bool is_same(const planes *p) {
  return !memcmp(p->picture, p->reference, (size_t)p->width * p->height * sizeof *p->picture);
}

static void choose_source(planes *p, const neph_image *reference) {
  if (is_same(p)) {
    np_alloc_free(p->context, p->reference_error);
    p->reference_error = NULL;
    p->source = NEPH_NOISE_UNKNOWN;
    p->reference_variance = 0.0;
    return;
  }
  const double stated = np_image_get_stated_noise(reference).value;
  const bool is_stated = !p->reference_error && isfinite(stated);
  p->source = p->reference_error ? NEPH_NOISE_BY_PIXEL : is_stated ? NEPH_NOISE_BY_HEADER : NEPH_NOISE_UNKNOWN;
  p->noise_share = is_stated ? stated : 0.0;
}

static double compute_dim(const planes *p) {
  double sum = 0.0;
  size_t finite_count = 0;
  for (size_t i = 0; i < (size_t)p->width * p->height; i++)
    if (isfinite(p->reference[i])) sum += p->reference[i], finite_count++;
  return finite_count ? dim_of_mean * fmax(sum / (double)finite_count, 0.0) : 0.0;
}

/* Root mean square of standard errors relative to the scale. */
static double measure_channels(const planes *p) {
  double sum = 0.0, count = 0.0;
  for (size_t i = 0; i < (size_t)p->width * p->height; i++) {
    if (!isfinite(p->reference[i]) || !isfinite(p->reference_error[i]) || !(p->scale[i] > p->dim)) continue;
    sum += pow(p->reference_error[i] / p->scale[i], 2.0);
    count += 1.0;
  }
  return sqrt(sum / count);
}

static neph_result fill_own_planes(planes *p, const neph_image *image) {
  unsigned *indices = np_alloc(p->context, image->channel_count, sizeof *indices);
  if (!indices) return NEPH_ERROR_OUT_OF_MEMORY;
  const luminance l = choose_luminance(image, indices);
  neph_result result = fill_plane(p, image, image, &l, "", &p->reference);
  if (!result) result = fill_plane(p, image, image, &l, "standard_error.", &p->reference_error);
  if (!result && p->reference_error) result = fill_scale(p);
  if (!result) p->dim = compute_dim(p);
  np_alloc_free(p->context, indices);
  return result;
}

neph_result np_image_compute_noise_factor(neph_context *context, const neph_image *image, double *out_factor) {
  planes p = {.context = context, .width = image->width, .height = image->height, .source = NEPH_NOISE_BY_PIXEL};
  const double stated = np_image_get_stated_noise(image).value;
  *out_factor = 1.0;
  if (!isfinite(stated)) return NEPH_OK;
  const neph_result result = fill_own_planes(&p, image);
  const double measured = !result && p.reference_error ? measure_channels(&p) : 0.0;
  if (measured > stated) *out_factor = stated / measured;
  free_planes(&p);
  return result;
}

static neph_result scale_errors(const planes *p, const neph_image *image, double *errors, double *out_variance) {
  double factor = 1.0;
  moments stated;
  const neph_result result = errors ? np_image_compute_noise_factor(p->context, image, &factor) : NEPH_OK;
  for (size_t i = 0; errors && i < (size_t)p->width * p->height; i++) errors[i] *= factor;
  if (factor < 1.0 && get_stated_noise(image, &stated)) *out_variance = stated.variance;
  return result;
}

static neph_result fill_planes(planes *p, const neph_image *image, const neph_image *second,
                               const neph_image *reference) {
  unsigned *indices = np_alloc(p->context, reference->channel_count, sizeof *indices);
  if (!indices) return NEPH_ERROR_OUT_OF_MEMORY;
  const luminance l = choose_luminance(reference, indices);
  neph_result result = fill_plane(p, image, reference, &l, "", &p->picture);
  if (!result) result = fill_plane(p, reference, reference, &l, "", &p->reference);
  if (!result && second) result = fill_plane(p, second, reference, &l, "", &p->second);
  if (!result) result = fill_plane(p, image, reference, &l, "standard_error.", &p->picture_error);
  if (!result) result = fill_plane(p, reference, reference, &l, "standard_error.", &p->reference_error);
  if (!result) result = scale_errors(p, image, p->picture_error, &p->picture_variance);
  if (!result) result = scale_errors(p, reference, p->reference_error, &p->reference_variance);
  if (!result) choose_source(p, reference);
  if (!result) result = fill_scale(p);
  if (!result) p->dim = compute_dim(p);
  np_alloc_free(p->context, indices);
  return result;
}

/* ---- Squares ---- */

/* Sums over pixels of squares relative to the squared scale. */
typedef struct squares {
  double error, noise, bias, reference;
  uint64_t count;
} squares;

static void add_pixel(const planes *p, size_t i, squares *sums) {
  const double reference = p->reference[i], difference = p->picture[i] - reference, scale = p->scale[i];
  if (!isfinite(reference) || !(scale > p->dim)) return;
  const double own = get_reference_error(p, i, scale);
  const double by = 1.0 / (scale * scale), error = (difference * difference - own * own) * by;
  sums->error += error;
  sums->reference += own * own * by;
  sums->count++;
  if (p->second) {
    sums->noise += 0.5 * pow(p->picture[i] - p->second[i], 2.0) * by;
    sums->bias += (difference * (p->second[i] - reference) - own * own) * by;
  } else if (p->picture_error) {
    const double noise = isfinite(p->picture_error[i]) ? pow(p->picture_error[i], 2.0) * by : 0.0;
    sums->noise += noise;
    sums->bias += error - noise;
  }
}

static squares sum_block(const planes *p, unsigned left, unsigned top) {
  squares sums = {0.0, 0.0, 0.0, 0.0, 0};
  for (unsigned y = top; y < top + BLOCK_PIXELS && y < p->height; y++)
    for (unsigned x = left; x < left + BLOCK_PIXELS && x < p->width; x++) add_pixel(p, (size_t)y * p->width + x, &sums);
  return sums;
}

/* Mean of squares and its variance, as a ratio of sums over blocks (Cochran 1977, "Sampling Techniques", eq. 6.13,
 * without the correction for a finite population). */
static moments compute_moments(const squares *blocks, size_t count, size_t member) {
  double sum = 0.0, pixels = 0.0, residual2 = 0.0;
  size_t filled = 0;
  for (size_t i = 0; i < count; i++) {
    sum += *(const double *)((const char *)&blocks[i] + member);
    pixels += (double)blocks[i].count;
    filled += blocks[i].count > 0;
  }
  const double mean = pixels > 0.0 ? sum / pixels : (double)NAN;
  for (size_t i = 0; i < count; i++) {
    const double block = *(const double *)((const char *)&blocks[i] + member);
    residual2 += pow(block - mean * (double)blocks[i].count, 2.0);
  }
  const double n = (double)filled;
  return (moments){mean, filled > 1 ? residual2 * n / (n - 1.0) / (pixels * pixels) : (double)NAN};
}

static double take_root(double square) { return isnan(square) ? square : sqrt(fmax(square, 0.0)); }

/* Root with its bounds; NaN where no square within the bounds is positive: stated noise exceeds the measured. */
static neph_bounded bound_root(moments m) {
  const double half = normal_quantile_975 * sqrt(m.variance);
  if (m.mean < 0.0 && !(m.mean + half > 0.0)) return unknown;
  return (neph_bounded){take_root(m.mean), take_root(m.mean - half), take_root(m.mean + half)};
}

/* ---- Measures ---- */

/* Raises an error to its random part, unless the pictures share noise. */
static void floor_error(neph_bounded *error, const neph_bounded *noise) {
  if (!(error->value < noise->value)) return;
  error->value = noise->value;
  if (error->max < noise->max) error->max = noise->max;
}

static moments widen(moments m, double variance) { return (moments){m.mean, m.variance + variance}; }

/* Fills the reference's noise. Returns the variance of its square from the header's bounds. */
static double measure_reference(const planes *p, const neph_image *reference, const squares *blocks, size_t count,
                                neph_image_difference *out) {
  moments stated;
  const bool is_stated = p->source == NEPH_NOISE_BY_HEADER && get_stated_noise(reference, &stated);
  out->reference_noise_source = p->source;
  out->reference_noise = unknown;
  if (p->source == NEPH_NOISE_BY_HEADER) out->reference_noise = np_image_get_stated_noise(reference);
  if (p->source == NEPH_NOISE_BY_PIXEL)
    out->reference_noise =
        bound_root(widen(compute_moments(blocks, count, offsetof(squares, reference)), p->reference_variance));
  return is_stated ? stated.variance : p->reference_variance;
}

static neph_result measure(const planes *p, const neph_image *image, const neph_image *reference,
                           neph_image_difference *out) {
  const unsigned columns = (p->width + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
  const size_t count = (size_t)columns * ((p->height + BLOCK_PIXELS - 1) / BLOCK_PIXELS);
  squares *blocks = np_alloc(p->context, count, sizeof *blocks);
  if (!blocks) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++) {
    blocks[i] = sum_block(p, (unsigned)(i % columns) * BLOCK_PIXELS, (unsigned)(i / columns) * BLOCK_PIXELS);
    out->pixel_count += blocks[i].count;
  }
  const double reference_variance = measure_reference(p, reference, blocks, count, out);
  const moments error = widen(compute_moments(blocks, count, offsetof(squares, error)), reference_variance);
  moments stated;
  out->pixel_error = bound_root(error);
  out->pixel_noise = out->pixel_bias = unknown;
  if (p->second || p->picture_error) {
    const double own = p->second ? 0.0 : p->picture_variance;
    out->pixel_noise = bound_root(widen(compute_moments(blocks, count, offsetof(squares, noise)), own));
    out->pixel_bias =
        bound_root(widen(compute_moments(blocks, count, offsetof(squares, bias)), own + reference_variance));
  } else if (get_stated_noise(image, &stated)) {
    out->pixel_noise = bound_root(stated);
    out->pixel_bias = bound_root((moments){error.mean - stated.mean, error.variance + stated.variance});
  }
  if (p->source != NEPH_NOISE_UNKNOWN) floor_error(&out->pixel_error, &out->pixel_noise);
  np_alloc_free(p->context, blocks);
  return NEPH_OK;
}

neph_result np_image_measure_error(neph_context *context, const neph_image *image, const neph_image *second,
                                   const neph_image *reference, neph_image_difference *out) {
  planes p = {.context = context, .width = reference->width, .height = reference->height};
  out->pixel_count = 0;
  neph_result result = fill_planes(&p, image, second, reference);
  if (!result) result = measure(&p, image, reference, out);
  free_planes(&p);
  return result;
}
