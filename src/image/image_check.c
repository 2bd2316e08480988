/* SPDX-License-Identifier: Apache-2.0 */
/* Checks whether the values of an image fit a file and a pixel type, and whether the claims of a file are plausible. */
#include <math.h>
#include <stdlib.h>

#include "image/image_private.h"

static const float half_overflow = 65520.0f;   /* the least value that rounds to infinity */
static const float half_normal_min = 0x1p-14f; /* smallest half with full precision */
static const char scale_attribute[] = "nephos:scale";

static double get_scale(const neph_image *image) {
  const char *scale = neph_image_get_attribute(image, scale_attribute);
  double value = scale ? strtod(scale, NULL) : 1.0;
  return value > 0 ? value : 1.0;
}

/* Result of the scan of one channel. */
typedef struct channel_scan {
  size_t infinite_at, nan_at, largest_at; /* index of the first such value; SIZE_MAX: none */
  size_t infinite_count, nan_count;
  float largest; /* largest finite magnitude */
} channel_scan;

static channel_scan scan_channel(const neph_image *image, const np_image_channel *channel) {
  channel_scan scan = {SIZE_MAX, SIZE_MAX, SIZE_MAX, 0, 0, 0.0f};
  size_t count = (size_t)image->width * image->height;
  for (size_t i = 0; i < count; i++) {
    float magnitude = fabsf(channel->values[i]);
    if (magnitude <= scan.largest) continue;
    if (isnan(magnitude)) {
      if (scan.nan_count++ == 0) scan.nan_at = i;
    } else if (isinf(magnitude)) {
      if (scan.infinite_count++ == 0) scan.infinite_at = i;
    } else {
      scan.largest = magnitude;
      scan.largest_at = i;
    }
  }
  return scan;
}

static void warn_of_count(const neph_image *image, const char *path, const np_image_channel *channel,
                          const char *values, size_t count, size_t first_at) {
  if (count == 0) return;
  np_log(image->context, NEPH_LOG_WARNING, "%s: channel %s holds %zu %s, the first at pixel (%d, %d)", path,
         channel->name, count, values, np_image_get_data_min(image, 0) + (int)(first_at % image->width),
         np_image_get_data_min(image, 1) + (int)(first_at / image->width));
}

static void warn_of_overflow(const neph_image *image, const char *path, const np_image_channel *channel,
                             const channel_scan *scan) {
  double scale = get_scale(image), fitting = scale;
  for (double value = (double)scan->largest; value >= (double)half_overflow; value *= 0.5) fitting *= 0.5;
  np_log(image->context, NEPH_LOG_WARNING,
         "%s: is written as float: pixel (%d, %d) of channel %s is %g, above 65504, the largest half; for halves set "
         "output.scale to %g (it is %g)",
         path, np_image_get_data_min(image, 0) + (int)(scan->largest_at % image->width),
         np_image_get_data_min(image, 1) + (int)(scan->largest_at / image->width), channel->name,
         (double)channel->values[scan->largest_at], fitting, scale);
}

/* Whether more than half of the lit pixels lie below `threshold` in their brightest channel. */
static bool is_median_below(const neph_image *image, float threshold) {
  const float *r = neph_image_get_values(image, "R"), *g = neph_image_get_values(image, "G"),
              *b = neph_image_get_values(image, "B");
  size_t count = (size_t)image->width * image->height, lit = 0, below = 0;
  for (size_t i = 0; i < count; i++) {
    float brightest = fmaxf(r[i], fmaxf(g[i], b[i]));
    lit += brightest > 0;
    below += brightest > 0 && brightest < threshold;
  }
  return below > lit / 2;
}

/* Whether halves would lose the precision of a picture of radiances; other pictures have no scale to set. */
static bool is_too_dark(const neph_image *image) {
  return np_image_search_attribute(image, scale_attribute) && neph_image_get_values(image, "R") &&
         neph_image_get_values(image, "G") && neph_image_get_values(image, "B") &&
         is_median_below(image, half_normal_min);
}

static void warn_of_darkness(const neph_image *image, const char *path, float largest) {
  float factor = 1.0f;
  while (is_median_below(image, half_normal_min / factor)) factor *= 2.0f;
  /* Adds up to four stops for the darker half, as far as the brightest value allows. */
  for (int stops = 0; stops < 4 && largest * factor * 2.0f < half_overflow; stops++) factor *= 2.0f;
  if (largest * factor >= half_overflow)
    np_log(image->context, NEPH_LOG_WARNING,
           "%s: is written as float: more than half of the lit pixels are below 2^-14, where halves lose digits, while "
           "others are as bright as %g, so that no scale fits both; set output.pixel_type to float",
           path, (double)largest);
  else
    np_log(image->context, NEPH_LOG_WARNING,
           "%s: is written as float: more than half of the lit pixels are below 2^-14, where halves lose digits; for "
           "halves set output.scale to %g (it is %g)",
           path, get_scale(image) * (double)factor, get_scale(image));
}

neph_pixel_type np_image_choose_pixel_type(const neph_image *image, const char *path, neph_pixel_type wanted) {
  const np_image_channel *brightest = NULL;
  channel_scan brightest_scan = {.largest = 0.0f};
  for (unsigned c = 0; c < image->channel_count; c++) {
    const np_image_channel *channel = &image->channels[c];
    bool is_float = np_image_is_float_channel(channel->name);
    channel_scan scan = scan_channel(image, channel);
    warn_of_count(image, path, channel, "NaN", scan.nan_count, scan.nan_at);
    if (!is_float) warn_of_count(image, path, channel, "infinite values", scan.infinite_count, scan.infinite_at);
    if (is_float || scan.largest <= brightest_scan.largest) continue;
    brightest = channel;
    brightest_scan = scan;
  }
  if (wanted == NEPH_PIXEL_FLOAT || !brightest) return wanted;
  const bool overflows = brightest_scan.largest >= half_overflow;
  if (!overflows && !is_too_dark(image)) return wanted;
  if (overflows)
    warn_of_overflow(image, path, brightest, &brightest_scan);
  else
    warn_of_darkness(image, path, brightest_scan.largest);
  return NEPH_PIXEL_FLOAT;
}

neph_pixel_type np_image_get_pixel_type(const neph_image *image, neph_pixel_type wanted) {
  float largest = 0.0f;
  for (unsigned c = 0; wanted == NEPH_PIXEL_HALF && c < image->channel_count; c++)
    if (!np_image_is_float_channel(image->channels[c].name))
      largest = fmaxf(largest, scan_channel(image, &image->channels[c]).largest);
  return largest >= half_overflow || (largest > 0.0f && is_too_dark(image)) ? NEPH_PIXEL_FLOAT : wanted;
}

neph_result np_image_check_claims(neph_context *context, const char *path, int64_t width, int64_t height,
                                  int channel_count) {
  const bool is_allowed = width >= 1 && width <= NP_IMAGE_SIDE_MAX && height >= 1 && height <= NP_IMAGE_SIDE_MAX &&
                          channel_count >= 1 && channel_count <= NP_IMAGE_CHANNELS_MAX;
  if (is_allowed && (uint64_t)(width * height * channel_count) * sizeof(float) <= NP_IMAGE_BYTES_MAX) return NEPH_OK;
  return np_fail(
      context, NEPH_ERROR_BAD_FILE,
      "%s: claims %lld × %lld pixels of %d channels, must be 1 to %d each way, 1 to %d channels, and at most "
      "%d GiB in memory",
      path, (long long)width, (long long)height, channel_count, NP_IMAGE_SIDE_MAX, NP_IMAGE_CHANNELS_MAX,
      (int)(NP_IMAGE_BYTES_MAX >> 30));
}
