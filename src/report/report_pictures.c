/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_pictures.h"

#include <math.h>

#include "core/alloc.h"
#include "image/exposure.h"

const float np_report_difference_colors[3][3] = {{0.13f, 0.40f, 0.67f}, {0.93f, 0.93f, 0.91f}, {0.70f, 0.09f, 0.17f}};

static const char *const names[] = {"R", "G", "B"};

/* ---- Bytes in a page ---- */

/* RFC 4648. */
static void add_base64(np_text *text, const uint8_t *bytes, size_t size) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < size; i += 3) {
    const size_t left = size - i;
    const unsigned bits = (unsigned)bytes[i] << 16 | (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0u) |
                          (left > 2 ? (unsigned)bytes[i + 2] : 0u);
    np_text_add(text, "%c%c%c%c", digits[bits >> 18], digits[bits >> 12 & 63], left > 1 ? digits[bits >> 6 & 63] : '=',
                left > 2 ? digits[bits & 63] : '=');
  }
}

static neph_result add_image(np_text *text, const neph_image *image, const neph_preview_desc *desc, const char *alt) {
  void *bytes;
  size_t size;
  neph_result result = np_image_encode_png(image, desc, &bytes, &size);
  if (result) return result;
  np_text_add(text, "<img width=\"%u\" height=\"%u\" alt=\"%s\" src=\"data:image/png;base64,", image->width,
              image->height, alt);
  add_base64(text, bytes, size);
  np_text_add(text, "\"/>");
  np_alloc_free(image->context, bytes);
  return NEPH_OK;
}

/* ---- Previews ---- */

/* Preview settings: all pictures get the automatic exposure of the march's picture. */
static neph_preview_desc get_preview(const neph_report *report) {
  neph_preview_desc desc = report->preview;
  const neph_image *picture = report->guide->pictures[0];
  if (desc.exposure != NEPH_EXPOSURE_AUTO || !picture) return desc;
  desc.exposure = NEPH_EXPOSURE_FIXED;
  desc.exposure_ev += log2(np_exposure_choose_by_picture(picture, &desc));
  return desc;
}

/* Other exposures depend on its attributes, which a file may lack. */
static neph_result copy_header(const neph_report *report, neph_image *out) {
  const neph_image *from = report->guide->pictures[0];
  neph_result result = NEPH_OK;
  if (from) out->header = from->header;
  for (unsigned i = 0; from && !result && i < from->attribute_count; i++)
    result = neph_image_set_attribute(out, from->attributes[i].name, from->attributes[i].value);
  return result;
}

static neph_result add_mean(np_text *text, const neph_report *report, const neph_image *first, const neph_image *second,
                            const char *alt) {
  neph_image *shown;
  neph_result result = neph_image_create(report->context, first->width, first->height, 3, names, &shown);
  if (result) return result;
  for (int c = 0; c < 3; c++) {
    const float *a = neph_image_get_values(first, names[c]), *b = neph_image_get_values(second, names[c]);
    float *out = neph_image_get_channel(shown, names[c]);
    for (size_t i = 0; i < (size_t)first->width * first->height; i++) out[i] = 0.5f * (a[i] + b[i]);
  }
  result = copy_header(report, shown);
  const neph_preview_desc desc = get_preview(report);
  if (!result) result = add_image(text, shown, &desc, alt);
  neph_image_destroy(shown);
  return result;
}

neph_result np_report_add_preview(np_text *text, const neph_report *report, const neph_image *picture,
                                  const char *alt) {
  return add_mean(text, report, picture, picture, alt);
}

neph_result np_report_add_setting(np_text *text, const neph_report *report, const np_setting *setting,
                                  const char *alt) {
  return add_mean(text, report, setting->pictures[0], setting->pictures[1], alt);
}

/* ---- Differences ---- */

enum { RADIUS = 2 };

/* Σ difference / Σ reference about a pixel, over all colours. */
static double get_difference(const np_setting *setting, const neph_image *reference, int x, int y) {
  double difference = 0.0, sum = 0.0;
  const int width = (int)reference->width, height = (int)reference->height;
  for (int c = 0; c < 3; c++) {
    const float *r = neph_image_get_values(reference, names[c]),
                *a = neph_image_get_values(setting->pictures[0], names[c]),
                *b = neph_image_get_values(setting->pictures[1], names[c]);
    for (int v = y < RADIUS ? 0 : y - RADIUS; v <= y + RADIUS && v < height; v++)
      for (int u = x < RADIUS ? 0 : x - RADIUS; u <= x + RADIUS && u < width; u++) {
        const size_t i = (size_t)v * (size_t)width + (size_t)u;
        difference += 0.5 * ((double)a[i] + (double)b[i]) - (double)r[i];
        sum += (double)r[i];
      }
  }
  return sum > 0.0 ? difference / sum : 0.0;
}

/* Colour of a relative difference, interpolated between the colours of −max, 0 and +max. */
static void color_difference(double difference, float out[3]) {
  const float share = (float)fmin(fabs(difference) / NP_REPORT_DIFFERENCE_MAX, 1.0);
  const float *end = np_report_difference_colors[difference < 0.0 ? 0 : 2], *middle = np_report_difference_colors[1];
  for (int c = 0; c < 3; c++) out[c] = middle[c] + share * (end[c] - middle[c]);
}

neph_result np_report_add_difference(np_text *text, const neph_report *report, const np_setting *setting,
                                     const char *alt) {
  const neph_image *reference = report->reference.picture;
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  desc.view = NEPH_VIEW_RAW;
  desc.exposure = NEPH_EXPOSURE_FIXED;
  neph_image *shown;
  neph_result result = neph_image_create(report->context, reference->width, reference->height, 3, names, &shown);
  if (result) return result;
  for (unsigned y = 0; y < reference->height; y++)
    for (unsigned x = 0; x < reference->width; x++) {
      float color[3];
      color_difference(get_difference(setting, reference, (int)x, (int)y), color);
      for (int c = 0; c < 3; c++) neph_image_get_channel(shown, names[c])[(size_t)y * reference->width + x] = color[c];
    }
  result = add_image(text, shown, &desc, alt);
  neph_image_destroy(shown);
  return result;
}
