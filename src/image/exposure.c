/* SPDX-License-Identifier: Apache-2.0 */
/* Exposure of a preview: by the luminances of the picture, by the light on the scene, or by a camera. */
#include "image/exposure.h"

#include <math.h>
#include <stdlib.h>

#include "image/preview_planes.h"

static const float rec709_luminance[3] = {0.2126f, 0.7152f, 0.0722f};

/* Histogram of log luminance, sixteen bins a stop. */
enum { BINS_PER_STOP = 16, STOPS_EITHER_WAY = 64, BIN_COUNT = 2 * STOPS_EITHER_WAY * BINS_PER_STOP };

typedef struct luminance_histogram {
  uint64_t bin[BIN_COUNT], count;
} luminance_histogram;

static double get_bin_stops(int bin) { return (bin + 0.5) / BINS_PER_STOP - STOPS_EITHER_WAY; }

/* Luminance of a pixel. Negative components, of colours outside Rec.709, count as 0. */
static float compute_luminance(const np_preview_planes *planes, float rgb[3]) {
  float luminance = 0.0f;
  np_preview_convert(planes, rgb);
  for (int c = 0; c < 3; c++) luminance += rec709_luminance[c] * fmaxf(rgb[c], 0.0f);
  return luminance;
}

static void fill_histogram(const np_preview_planes *planes, size_t pixel_count, luminance_histogram *out) {
  *out = (luminance_histogram){.count = 0};
  for (size_t i = 0; i < pixel_count; i++) {
    float rgb[3];
    np_preview_get_pixel(planes, i, rgb);
    const float luminance = compute_luminance(planes, rgb);
    if (!(luminance > 0) || !isfinite(luminance)) continue;
    float bin = (log2f(luminance) + STOPS_EITHER_WAY) * BINS_PER_STOP;
    out->bin[(int)fminf(fmaxf(bin, 0.0f), BIN_COUNT - 1)]++;
    out->count++;
  }
}

/* The bin in which the cumulative fraction of pixels is reached. */
static int search_bin(const luminance_histogram *histogram, double fraction) {
  uint64_t below = 0;
  int bin = 0;
  for (; bin < BIN_COUNT - 1; bin++) {
    below += histogram->bin[bin];
    if ((double)below >= fraction * (double)histogram->count) break;
  }
  return bin;
}

static void drop_below(luminance_histogram *histogram, int first_bin) {
  for (int bin = 0; bin < first_bin; bin++) {
    histogram->count -= histogram->bin[bin];
    histogram->bin[bin] = 0;
  }
}

static double average_stops(const luminance_histogram *histogram, int first_bin, int last_bin) {
  double sum = 0, count = 0;
  for (int bin = first_bin; bin <= last_bin; bin++) {
    sum += (double)histogram->bin[bin] * get_bin_stops(bin);
    count += (double)histogram->bin[bin];
  }
  return sum / count;
}

/* Exposes for the highlights: the 99.3rd percentile of luminance comes to 0.92, above which the sun, its glints and
 * noise are left to the shoulder. A picture of little light around much, such as one against the sun, is not left in
 * the dark: the log-average of the rest comes to 0.08 at least. Pixels twelve stops under the highlights count as
 * unlit. */
static double choose_by_picture(const np_preview_planes *planes, size_t pixel_count) {
  static const double bright_share = 0.993, bright_to = 0.92, average_to_at_least = 0.08;
  enum { LIT_STOPS = 12 };
  luminance_histogram histogram;
  fill_histogram(planes, pixel_count, &histogram);
  if (histogram.count == 0) return 1.0;
  int bright = search_bin(&histogram, bright_share);
  drop_below(&histogram, bright - LIT_STOPS * BINS_PER_STOP);
  bright = search_bin(&histogram, bright_share);
  const double average = average_stops(&histogram, search_bin(&histogram, 0.10), bright);
  return fmax(bright_to / exp2(get_bin_stops(bright)), average_to_at_least / exp2(average));
}

/* Share of full exposure for a luminance of the white diffuser in cd/m²: the key of Krawczyk, Myszkowski and Seidel
 * 2005 ("Perceptual Effects in Real-time Tone Mapping", eq. 11), relative to noon. */
static double compute_key(double luminance) {
  static const double noon = 3e4;
  const double key = 1.03 - 2.0 / (2.0 + log10(luminance + 1.0)), key_of_noon = 1.03 - 2.0 / (2.0 + log10(noon + 1.0));
  return fmin(key / key_of_noon, 1.0);
}

static neph_result get_number(const neph_image *image, const char *exposure, const char *name, double *out) {
  const char *value = neph_image_get_attribute(image, name);
  if (!value)
    return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT,
                   "the picture has no attribute %s, by which the %s exposes it: choose another exposure", name,
                   exposure);
  *out = strtod(value, NULL);
  return NEPH_OK;
}

/* Exposure by the light on the scene: a white diffuser comes to 0.8 by day, and to less in the dark. */
static neph_result choose_by_light(const neph_image *image, double *out) {
  static const double diffuser_to = 0.8;
  double diffuser = 0.0, luminance = 0.0;
  neph_result result = get_number(image, "meter", NP_EXPOSURE_METER, &diffuser);
  if (!result) result = get_number(image, "meter", NP_EXPOSURE_METER_LUMINANCE, &luminance);
  if (!result) *out = diffuser > 0.0 ? diffuser_to * compute_key(luminance) / diffuser : 1.0;
  return result;
}

/* Exposure by the camera, from saturation-based sensitivity (ISO 12232): 78/(100·0.65)·2^EV100 cd/m² saturate a sensor
 * behind a lens that transmits 0.65 of the light (Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based
 * Rendering", 5.1). */
static neph_result choose_by_camera(const neph_image *image, double *out) {
  double diffuser = 0.0, luminance = 0.0, ev100 = 0.0;
  neph_result result = get_number(image, "camera", NP_EXPOSURE_EV100, &ev100);
  if (!result) result = get_number(image, "camera", NP_EXPOSURE_METER, &diffuser);
  if (!result) result = get_number(image, "camera", NP_EXPOSURE_METER_LUMINANCE, &luminance);
  if (!result) *out = diffuser > 0.0 ? luminance / diffuser / (1.2 * exp2(ev100)) : 1.0;
  return result;
}

double np_exposure_get_luminance(const neph_image *image, const float rgb[3]) {
  np_preview_planes planes;
  float color[3] = {rgb[0], rgb[1], rgb[2]};
  np_preview_choose_primaries(image, &planes);
  return (double)compute_luminance(&planes, color);
}

void np_exposure_convert(const neph_image *image, const float rgb[3], double out_rec709[3]) {
  np_preview_planes planes;
  float color[3] = {rgb[0], rgb[1], rgb[2]};
  np_preview_choose_primaries(image, &planes);
  np_preview_convert(&planes, color);
  for (int c = 0; c < 3; c++) out_rec709[c] = (double)color[c];
}

double np_exposure_choose_by_picture(const neph_image *image, const neph_preview_desc *desc) {
  np_preview_planes planes;
  if (!np_preview_get_planes(image, desc->pixel_type, &planes)) return 1.0;
  for (int c = 0; c < 3; c++) planes.factor[c] = (float)(1.0 / desc->white[c]);
  return choose_by_picture(&planes, (size_t)image->width * image->height);
}

neph_result np_exposure_choose(const neph_image *image, const neph_preview_desc *desc, double *out_factor) {
  *out_factor = 1.0;
  if (desc->exposure == NEPH_EXPOSURE_METER) return choose_by_light(image, out_factor);
  if (desc->exposure == NEPH_EXPOSURE_CAMERA) return choose_by_camera(image, out_factor);
  if (desc->exposure == NEPH_EXPOSURE_AUTO) *out_factor = np_exposure_choose_by_picture(image, desc);
  return NEPH_OK;
}
