/* SPDX-License-Identifier: Apache-2.0 */
/* Difference of a picture from a reference: the measures of docs/accuracy.md. Sums run in double over pixels in order,
 * so that the figures repeat. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "image/image_error.h"

enum { BLOCK_PIXELS = 8 };

static const double epsilon_of_mean = 0.01;
static const double normal_quantile_975 = 1.959963984540054; /* two-sided 95 % interval */

/* Planes of the two pictures. */
typedef struct comparison {
  neph_context *context;
  unsigned width, height, channel_count;
  const char **names;
  const float **values, **reference;
  const float **noise; /* standard errors of the reference; NULL without */
  bool has_channels;   /* whether the reference has all channels of standard errors */
  double noise_factor; /* factor on these channels */
  double noise_share;  /* noise of the reference relative to its values, from its header, without channels of standard
                          errors; NaN: unknown */
  double epsilon;
} comparison;

/* ---- Comparability ---- */

static void free_planes(comparison *pair) {
  np_alloc_free(pair->context, pair->names);
  np_alloc_free(pair->context, pair->values);
  np_alloc_free(pair->context, pair->reference);
  np_alloc_free(pair->context, pair->noise);
}

static neph_result allocate_planes(comparison *pair, unsigned count) {
  pair->names = np_alloc(pair->context, count, sizeof *pair->names);
  pair->values = np_alloc(pair->context, count, sizeof *pair->values);
  pair->reference = np_alloc(pair->context, count, sizeof *pair->reference);
  pair->noise = np_alloc(pair->context, count, sizeof *pair->noise);
  return pair->names && pair->values && pair->reference && pair->noise ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result choose_planes(comparison *pair, const neph_image *image, const neph_image *reference) {
  neph_result result = allocate_planes(pair, reference->channel_count);
  unsigned *indices = result ? NULL : np_alloc(pair->context, reference->channel_count, sizeof *indices);
  if (!indices) return NEPH_ERROR_OUT_OF_MEMORY;
  pair->channel_count = np_image_choose_channels(reference, indices);
  for (unsigned c = 0; !result && c < pair->channel_count; c++) {
    const np_image_channel *channel = &reference->channels[indices[c]];
    pair->names[c] = channel->name;
    pair->reference[c] = channel->values;
    pair->noise[c] = np_image_get_prefixed(reference, "standard_error.", channel->name);
    pair->values[c] = neph_image_get_values(image, channel->name);
    if (!pair->values[c])
      result = np_fail(pair->context, NEPH_ERROR_INVALID_ARGUMENT,
                       "the picture has no channel %s, which the reference has", channel->name);
  }
  np_alloc_free(pair->context, indices);
  return result;
}

static neph_result check_finite(const comparison *pair) {
  size_t count = (size_t)pair->width * pair->height;
  for (unsigned c = 0; c < pair->channel_count; c++)
    for (size_t i = 0; i < count; i++)
      if (!isfinite(pair->values[c][i]) && isfinite(pair->reference[c][i]))
        return np_fail(pair->context, NEPH_ERROR_INVALID_ARGUMENT,
                       "pixel (%zu, %zu) of channel %s is %g, where the reference is %g: no measure can hold it",
                       i % pair->width, i / pair->width, pair->names[c], (double)pair->values[c][i],
                       (double)pair->reference[c][i]);
  return NEPH_OK;
}

/* Refuses pictures of two colour spaces, whose channels differ in meaning. */
static neph_result check_spaces(neph_context *context, const neph_image *image, const neph_image *reference) {
  const char *space = neph_image_get_attribute(image, "nephos:colorSpace");
  const char *reference_space = neph_image_get_attribute(reference, "nephos:colorSpace");
  if (!space || !reference_space || !strcmp(space, reference_space)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "the picture's colours are %s and the reference's %s, must be of one space: render both with "
                 "the same output.color_space",
                 space, reference_space);
}

/* ε of relative differences, so that black pixels weigh no more than dim ones. */
static double compute_epsilon(const comparison *pair) {
  size_t count = (size_t)pair->width * pair->height, finite_count = 0;
  double sum = 0;
  for (unsigned c = 0; c < pair->channel_count; c++)
    for (size_t i = 0; i < count; i++)
      if (isfinite(pair->reference[c][i])) {
        sum += fabs((double)pair->reference[c][i]);
        finite_count++;
      }
  return finite_count ? epsilon_of_mean * sum / (double)finite_count : 0;
}

/* Chooses the reference's noise. Its values include the noise: E R² = L²(1 + n²). */
static neph_result choose_noise(comparison *pair, const neph_image *reference) {
  const double noise = np_image_get_stated_noise(reference).value;
  pair->has_channels = true;
  for (unsigned c = 0; c < pair->channel_count; c++) pair->has_channels &= pair->noise[c] != NULL;
  pair->noise_share = noise / sqrt(1.0 + noise * noise);
  return np_image_compute_noise_factor(pair->context, reference, &pair->noise_factor);
}

static neph_result begin_comparison(neph_context *context, const neph_image *image, const neph_image *reference,
                                    comparison *out) {
  *out = (comparison){.context = context, .width = reference->width, .height = reference->height};
  if (image->width != reference->width || image->height != reference->height)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "the picture is %u × %u pixels and the reference %u × %u, must be of one size", image->width,
                   image->height, reference->width, reference->height);
  neph_result result = check_spaces(context, image, reference);
  if (!result) result = choose_planes(out, image, reference);
  if (!result) result = choose_noise(out, reference);
  if (!result) result = check_finite(out);
  if (!result) out->epsilon = compute_epsilon(out);
  return result;
}

/* Quotient, with 0/0 = 0: no difference. */
static double divide(double difference, double by) { return difference == 0 ? 0 : difference / by; }

/* ---- Sums over values ---- */

typedef struct value_sums {
  double squared, relative_squared, largest;
  uint64_t count;
} value_sums;

static value_sums sum_values(const comparison *pair) {
  value_sums sums = {0};
  size_t count = (size_t)pair->width * pair->height;
  double epsilon2 = pair->epsilon * pair->epsilon;
  for (unsigned c = 0; c < pair->channel_count; c++)
    for (size_t i = 0; i < count; i++) {
      double reference = (double)pair->reference[c][i], difference = (double)pair->values[c][i] - reference;
      if (!isfinite(reference)) continue;
      double squared = difference * difference;
      sums.squared += squared;
      sums.relative_squared += divide(squared, reference * reference + epsilon2);
      sums.largest = fmax(sums.largest, fabs(difference));
      sums.count++;
    }
  return sums;
}

static void swap(float *a, float *b) {
  float kept = *a;
  *a = *b;
  *b = kept;
}

/* Hoare's selection: the value at `rank` in sorted order. */
static float select_rank(float *values, size_t count, size_t rank) {
  assert(rank < count);
  size_t low = 0, high = count - 1;
  while (low < high) {
    float pivot = values[low + (high - low) / 2];
    size_t i = low, j = high;
    for (;;) {
      while (values[i] < pivot) i++;
      while (values[j] > pivot) j--;
      if (i >= j) break;
      swap(&values[i++], &values[j--]);
    }
    if (rank <= j)
      high = j;
    else
      low = j + 1;
  }
  return values[rank];
}

static neph_result compute_percentile(const comparison *pair, uint64_t value_count, double *out_percentile) {
  *out_percentile = 0;
  if (value_count == 0) return NEPH_OK;
  float *relative = np_alloc(pair->context, value_count, sizeof *relative);
  if (!relative) return NEPH_ERROR_OUT_OF_MEMORY;
  size_t count = (size_t)pair->width * pair->height, next = 0;
  for (unsigned c = 0; c < pair->channel_count; c++)
    for (size_t i = 0; i < count; i++) {
      double reference = (double)pair->reference[c][i];
      if (!isfinite(reference)) continue;
      relative[next++] = (float)divide(fabs((double)pair->values[c][i] - reference), fabs(reference) + pair->epsilon);
    }
  size_t rank = (size_t)ceil(0.999 * (double)value_count);
  *out_percentile = (double)select_rank(relative, value_count, rank - 1);
  np_alloc_free(pair->context, relative);
  return NEPH_OK;
}

/* ---- Sums over blocks ---- */

typedef struct block_sum {
  double values, reference; /* sums over the block's pixels, all channels */
} block_sum;

typedef struct block_sums {
  double values, reference;          /* sums over the picture */
  double squared, reference_squared; /* sums of squared block means, over blocks and channels */
} block_sums;

/* Sums one channel of one block. */
static block_sum sum_block(const comparison *pair, unsigned c, unsigned left, unsigned top, unsigned *out_count) {
  block_sum sum = {0, 0};
  *out_count = 0;
  for (unsigned y = top; y < top + BLOCK_PIXELS && y < pair->height; y++)
    for (unsigned x = left; x < left + BLOCK_PIXELS && x < pair->width; x++) {
      size_t i = (size_t)y * pair->width + x;
      if (!isfinite(pair->reference[c][i])) continue;
      sum.values += (double)pair->values[c][i];
      sum.reference += (double)pair->reference[c][i];
      ++*out_count;
    }
  return sum;
}

static block_sum add_block(const comparison *pair, unsigned left, unsigned top, block_sums *sums) {
  block_sum block = {0, 0};
  for (unsigned c = 0; c < pair->channel_count; c++) {
    unsigned count;
    block_sum sum = sum_block(pair, c, left, top, &count);
    if (count == 0) continue;
    double mean = sum.reference / count, difference = (sum.values - sum.reference) / count;
    sums->squared += difference * difference;
    sums->reference_squared += mean * mean;
    block.values += sum.values;
    block.reference += sum.reference;
  }
  sums->values += block.values;
  sums->reference += block.reference;
  return block;
}

/* Half width of the bias's 95 % interval. The bias is a ratio of sums r = ΣP/ΣR over n blocks; its variance n/(n−1)·Σ(P
 * − rR)²/(ΣR)² (Cochran 1977, "Sampling Techniques", eq. 6.13, without the correction for a finite population). */
static double compute_bias_interval(const block_sum *blocks, size_t count, const block_sums *sums) {
  if (count < 2) return (double)NAN;
  double ratio = sums->values / sums->reference, residual2 = 0;
  for (size_t i = 0; i < count; i++) {
    double residual = blocks[i].values - ratio * blocks[i].reference;
    residual2 += residual * residual;
  }
  return normal_quantile_975 * sqrt(residual2 * (double)count / (double)(count - 1)) / fabs(sums->reference);
}

/* ---- The reference's own noise ---- */

typedef struct noise_sums {
  double squared, block_squared, bias_squared; /* sums over values, block means, and pixels' sums over channels */
} noise_sums;

static double get_noise_at(const comparison *pair, unsigned c, size_t i) {
  return pair->has_channels ? pair->noise_factor * (double)pair->noise[c][i]
                            : pair->noise_share * fabs((double)pair->reference[c][i]);
}

/* Adds the reference's noise in a block. Pixels are independent, the channels of a pixel are not: they are summed
 * first. */
static void add_block_noise(const comparison *pair, unsigned left, unsigned top, noise_sums *sums) {
  double bias_squared[BLOCK_PIXELS * BLOCK_PIXELS] = {0};
  for (unsigned c = 0; c < pair->channel_count; c++) {
    double squared = 0;
    unsigned count = 0;
    for (unsigned y = top; y < top + BLOCK_PIXELS && y < pair->height; y++)
      for (unsigned x = left; x < left + BLOCK_PIXELS && x < pair->width; x++) {
        const size_t i = (size_t)y * pair->width + x;
        const double noise = get_noise_at(pair, c, i);
        if (!isfinite(pair->reference[c][i]) || !isfinite(noise)) continue;
        squared += noise * noise;
        bias_squared[(y - top) * BLOCK_PIXELS + (x - left)] += noise;
        count++;
      }
    sums->squared += squared;
    if (count) sums->block_squared += squared / ((double)count * count);
  }
  for (int i = 0; i < BLOCK_PIXELS * BLOCK_PIXELS; i++) sums->bias_squared += bias_squared[i] * bias_squared[i];
}

static void measure_noise(const comparison *pair, const block_sums *blocks, uint64_t value_count,
                          neph_image_difference *out) {
  out->noise_rmse = out->noise_block_rms = out->noise_bias = (double)NAN;
  if (!pair->has_channels && isnan(pair->noise_share)) return;
  noise_sums sums = {0, 0, 0};
  for (unsigned top = 0; top < pair->height; top += BLOCK_PIXELS)
    for (unsigned left = 0; left < pair->width; left += BLOCK_PIXELS) add_block_noise(pair, left, top, &sums);
  out->noise_rmse = sqrt(divide(sums.squared, (double)value_count));
  out->noise_block_rms = sqrt(divide(sums.block_squared, blocks->reference_squared));
  out->noise_bias = divide(sqrt(sums.bias_squared), fabs(blocks->reference));
}

/* ---- Measures of blocks ---- */

static neph_result measure_blocks(const comparison *pair, neph_image_difference *out) {
  size_t columns = (pair->width + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
  size_t rows = (pair->height + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
  block_sum *blocks = np_alloc(pair->context, columns * rows, sizeof *blocks);
  if (!blocks) return NEPH_ERROR_OUT_OF_MEMORY;
  block_sums sums = {0};
  for (size_t i = 0; i < columns * rows; i++)
    blocks[i] = add_block(pair, (unsigned)(i % columns) * BLOCK_PIXELS, (unsigned)(i / columns) * BLOCK_PIXELS, &sums);
  out->bias = divide(sums.values - sums.reference, sums.reference);
  out->bias_interval =
      sums.values == sums.reference && sums.squared == 0 ? 0 : compute_bias_interval(blocks, columns * rows, &sums);
  out->block_rms = sqrt(divide(sums.squared, sums.reference_squared));
  measure_noise(pair, &sums, out->value_count, out);
  np_alloc_free(pair->context, blocks);
  return NEPH_OK;
}

/* ---- Bits ---- */

static uint64_t count_differing_bits(const float *a, const float *b, size_t count) {
  uint64_t differing = 0;
  for (size_t i = 0; i < count; i++) differing += memcmp(&a[i], &b[i], sizeof *a) != 0;
  return differing;
}

static uint64_t count_differing(const neph_image *image, const neph_image *reference) {
  uint64_t count = (uint64_t)image->width * image->height, differing = 0, shared = 0;
  for (unsigned c = 0; c < image->channel_count; c++) {
    const float *other = neph_image_get_values(reference, image->channels[c].name);
    if (!other) continue;
    differing += count_differing_bits(image->channels[c].values, other, count);
    shared++;
  }
  return differing + count * (image->channel_count + reference->channel_count - 2 * shared);
}

/* ---- Public ---- */

static neph_result measure(const comparison *pair, neph_image_difference *out) {
  const value_sums sums = sum_values(pair);
  const double count = sums.count ? (double)sums.count : 1;
  out->relative_mse = sums.relative_squared / count;
  out->rmse = sqrt(sums.squared / count);
  out->max_absolute = sums.largest;
  out->value_count = sums.count;
  neph_result result = compute_percentile(pair, sums.count, &out->p999_relative);
  return result ? result : measure_blocks(pair, out);
}

static neph_result compare(neph_context *context, const neph_image *image, const neph_image *second,
                           const neph_image *reference, neph_image_difference *out_difference) {
  comparison pair, second_pair = {.context = context};
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = begin_comparison(context, image, reference, &pair);
  if (!result && second) result = begin_comparison(context, second, reference, &second_pair);
  if (!result) result = measure(&pair, &difference);
  if (!result) result = np_image_measure_error(context, image, second, reference, &difference);
  if (!result) difference.differing_count = count_differing(image, reference);
  free_planes(&pair);
  free_planes(&second_pair);
  if (!result) result = np_desc_write(context, "neph_image_difference", &difference, sizeof difference, out_difference);
  return result;
}

neph_result neph_image_compare(neph_context *context, const neph_image *image, const neph_image *reference,
                               neph_image_difference *out_difference) {
  if (NP_LACKS(context, image, reference, out_difference)) return NEPH_ERROR_INVALID_ARGUMENT;
  return compare(context, image, NULL, reference, out_difference);
}

neph_result neph_image_compare_seeds(neph_context *context, const neph_image *image, const neph_image *second,
                                     const neph_image *reference, neph_image_difference *out_difference) {
  if (NP_LACKS(context, image, second, reference, out_difference)) return NEPH_ERROR_INVALID_ARGUMENT;
  return compare(context, image, second, reference, out_difference);
}

/* ---- The difference picture ---- */

static neph_result create_difference_image(const comparison *pair, neph_image **out_image) {
  neph_context *context = pair->context;
  unsigned count = pair->channel_count + 3;
  char **names = np_alloc(context, count, sizeof *names);
  if (!names) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < count; i++) {
    names[i] = i < 3 ? np_alloc_printf(context, "%c", "RGB"[i])
                     : np_alloc_printf(context, "difference.%s", pair->names[i - 3]);
    if (!names[i]) result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  if (!result)
    result = neph_image_create(context, pair->width, pair->height, count, (const char *const *)names, out_image);
  for (unsigned i = 0; i < count; i++) np_alloc_free(context, names[i]);
  np_alloc_free(context, names);
  return result;
}

/* Relative difference of a value: 0 where the reference is not finite, 1 where it is black throughout. */
static float compute_relative(const comparison *pair, unsigned c, size_t i) {
  double reference = (double)pair->reference[c][i];
  if (!isfinite(reference)) return 0;
  double relative = divide((double)pair->values[c][i] - reference, fabs(reference) + pair->epsilon);
  return (float)fmax(-1e30, fmin(1e30, relative));
}

static void fill_difference(const comparison *pair, neph_image *image) {
  size_t count = (size_t)pair->width * pair->height;
  for (size_t i = 0; i < count; i++) {
    double sum = 0;
    for (unsigned c = 0; c < pair->channel_count; c++) {
      float relative = compute_relative(pair, c, i);
      image->channels[3 + c].values[i] = relative;
      sum += (double)relative;
    }
    double mean = sum / pair->channel_count;
    image->channels[0].values[i] = (float)fmax(mean, 0);
    image->channels[2].values[i] = (float)fmax(-mean, 0);
  }
}

neph_result neph_image_create_difference(neph_context *context, const neph_image *image, const neph_image *reference,
                                         neph_image **out_image) {
  if (NP_LACKS_OUT(context, out_image, image, reference)) return NEPH_ERROR_INVALID_ARGUMENT;
  comparison pair;
  *out_image = NULL;
  neph_result result = begin_comparison(context, image, reference, &pair);
  if (!result) result = create_difference_image(&pair, out_image);
  if (!result) fill_difference(&pair, *out_image);
  free_planes(&pair);
  return result;
}
