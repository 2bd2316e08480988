/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of settings by docs/error.md, and effects of knobs, both by neph_image_compare_seeds, with pictures that are
 * shifted onto one yardstick. */
#include <math.h>

#include "image/image_private.h"
#include "report/report_private.h"

static const char *const channels[] = {"R", "G", "B", "standard_error.R", "standard_error.G", "standard_error.B"};
enum { COLOURS = 3, COLOURS_AND_ERRORS = 6 };

/* ---- Pictures ---- */

static neph_result create_picture(const neph_report *report, unsigned channel_count, neph_image **out_image) {
  const neph_image *reference = report->reference.picture;
  neph_result result =
      neph_image_create(report->context, reference->width, reference->height, channel_count, channels, out_image);
  if (result) return result;
  (*out_image)->header = reference->header;
  const char *space = neph_image_get_attribute(reference, "nephos:colorSpace");
  return space ? neph_image_set_attribute(*out_image, "nephos:colorSpace", space) : NEPH_OK;
}

static size_t count_pixels(const neph_image *image) { return (size_t)image->width * image->height; }

/* The yardstick plus the difference of two pictures, or of none: relative to the yardstick, that difference. */
static neph_result create_shifted(const neph_report *report, const neph_image *picture, const neph_image *from,
                                  neph_image **out_image) {
  neph_result result = create_picture(report, COLOURS, out_image);
  for (int c = 0; !result && c < COLOURS; c++) {
    float *out = neph_image_get_channel(*out_image, channels[c]);
    const float *base = neph_image_get_values(report->yardstick, channels[c]);
    const float *a = picture ? neph_image_get_values(picture, channels[c]) : base;
    const float *b = from ? neph_image_get_values(from, channels[c]) : base;
    for (size_t i = 0; i < count_pixels(*out_image); i++) out[i] = base[i] + (a[i] - b[i]);
  }
  return result;
}

/* ---- Yardstick ---- */

/* Bias of the march in a pixel, about. */
static const double march_error = 0.1;

/* Share of the march in the yardstick: where the reference is noisy, the march is the better guess of the truth. */
static float get_march_share(const neph_report *report) {
  const double noise = report->reference.noise.value;
  return isfinite(noise) ? (float)(noise * noise / (noise * noise + march_error * march_error)) : 0.0f;
}

/* Errors are relative to the truth, for which a reference of much noise would not do: where its noise left it dark, a
 * difference would be divided by too little, and the mean of squares, few of which are large, would be too large. */
neph_result np_report_make_yardstick(neph_report *report, neph_image *const march[2]) {
  const neph_image *reference = report->reference.picture;
  const bool has_noise = isfinite(report->reference.noise.value);
  const float share = get_march_share(report);
  const int count = has_noise ? COLOURS_AND_ERRORS : COLOURS;
  neph_image_difference ignored = NEPH_IMAGE_DIFFERENCE_DEFAULT; /* a file may not match the scene */
  neph_result result = neph_image_compare(report->context, march[0], reference, &ignored);
  if (!result) result = create_picture(report, (unsigned)count, &report->yardstick);
  for (int c = 0; !result && c < count; c++) {
    float *out = neph_image_get_channel(report->yardstick, channels[c]);
    const float *r = neph_image_get_values(reference, channels[c]);
    const float *a = neph_image_get_values(march[0], channels[c]), *b = neph_image_get_values(march[1], channels[c]);
    for (size_t i = 0; i < count_pixels(reference); i++)
      out[i] = c < COLOURS ? r[i] + share * (0.5f * (a[i] + b[i]) - r[i]) : r[i];
  }
  return result;
}

/* ---- Measures ---- */

/* Compares pictures of two seeds, each less a picture in `from`, with the reference `yardstick`. */
static neph_result compare(const neph_report *report, neph_image *const pictures[2], neph_image *const from[2],
                           const neph_image *yardstick, neph_image_difference *out) {
  neph_image *shifted[2] = {NULL, NULL};
  neph_result result = create_shifted(report, pictures[0], from[0], &shifted[0]);
  if (!result) result = create_shifted(report, pictures[1], from[1], &shifted[1]);
  if (!result) result = neph_image_compare_seeds(report->context, shifted[0], shifted[1], yardstick, out);
  for (int i = 0; i < 2; i++) neph_image_destroy(shifted[i]);
  return result;
}

/* Error of a picture without standard errors. */
static neph_result compare_exactly(const neph_report *report, neph_image *const pictures[2], neph_image *const from[2],
                                   neph_image_difference *out) {
  neph_image *exact = NULL;
  neph_result result = create_shifted(report, NULL, NULL, &exact);
  if (!result) result = compare(report, pictures, from, exact, out);
  neph_image_destroy(exact);
  return result;
}

static double get_half_width2(neph_bounded b) { return 0.5 * (b.max * b.max - b.min * b.min); }

/* Noise of one picture, from the noise of the mean of `count` pictures. */
static neph_bounded scale(neph_bounded b, unsigned count) {
  const double factor = sqrt(count);
  return (neph_bounded){factor * b.value, factor * b.min, factor * b.max};
}

/* error² = noise² + bias², whose estimates are independent but for the pixels that they share. */
static neph_bounded add(neph_bounded noise, neph_bounded bias) {
  const double error2 = noise.value * noise.value + bias.value * bias.value;
  const double half = hypot(get_half_width2(noise), bias.max * bias.max - bias.value * bias.value);
  return (neph_bounded){sqrt(error2), sqrt(fmax(error2 - half, 0.0)), sqrt(error2 + half)};
}

/* Measures an error. Each picture is compared with another half of the reference, so that the noise of the two factors
 * of the bias is independent. */
neph_result np_report_measure(const neph_report *report, np_setting *setting) {
  const np_report_reference *reference = &report->reference;
  neph_image *const whole[2] = {reference->picture, reference->picture};
  neph_image_difference same = NEPH_IMAGE_DIFFERENCE_DEFAULT, apart = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = compare(report, setting->pictures, whole, report->yardstick, &same);
  if (!result && reference->halves[0]) result = compare_exactly(report, setting->pictures, reference->halves, &apart);
  if (result) return result;
  setting->noise = scale(same.pixel_noise, setting->visit_count);
  setting->bias = reference->halves[0] ? apart.pixel_bias : same.pixel_bias;
  setting->error = add(setting->noise, setting->bias);
  return NEPH_OK;
}

neph_result np_report_measure_effect(const neph_report *report, const np_setting *finest, const np_setting *setting,
                                     neph_bounded *out_effect) {
  neph_image_difference d = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  neph_result result = compare_exactly(report, setting->pictures, finest->pictures, &d);
  if (!result) *out_effect = d.pixel_bias;
  return result;
}
