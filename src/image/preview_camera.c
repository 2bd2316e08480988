/* SPDX-License-Identifier: Apache-2.0 */
/* The view of a camera.
 *
 * Tone works on the largest component m of the light: the factor 1 + (2^0.45 − 1) · 2r/(1 + r²), r = m/0.22, a bell in
 * stops, lifts midtones by 0.45 stops and black by none; the shoulder of the filmic view follows. The other components
 * keep their ratio to m, and so their hue, but for saturation, which is raised by 1.12 about the luminance as far as no
 * component becomes negative: the dominant wavelength stays.
 */
#include "image/preview_camera.h"

#include <math.h>
#include <stdlib.h>

#include "core/math.h"
#include "image/exposure.h"
#include "image/glare.h"
#include "image/preview.h"

/* ---- Tone ---- */

/* Factor that lifts the midtones: 2^0.45 at the middle, 1 in black and far above white. */
static inline float lift(float peak) {
  static const float gain = 0.36604f, middle = 0.22f;
  return 1.0f + 2.0f * gain * middle * peak / (middle * middle + peak * peak);
}

/* Raises saturation as far as the least component stays positive. */
static void saturate(float rgb[3]) {
  static const float gain = 1.12f;
  const float luminance = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
  const float least = np_minf(rgb[0], np_minf(rgb[1], rgb[2])), room = luminance - least;
  const float factor = gain * room > luminance ? np_maxf(luminance / room, 1.0f) : gain;
  for (int c = 0; c < 3; c++) rgb[c] = np_maxf(luminance + factor * (rgb[c] - luminance), 0.0f);
}

void np_preview_map_camera(const float exposed[3], float out_display[3]) {
  float rgb[3];
  for (int c = 0; c < 3; c++) rgb[c] = np_maxf(exposed[c], 0.0f);
  saturate(rgb);
  const float peak = np_maxf(rgb[0], np_maxf(rgb[1], rgb[2])), factor = lift(np_minf(peak, 1e6f));
  for (int c = 0; c < 3; c++) rgb[c] *= factor;
  np_preview_map_tone(rgb, out_display);
}

/* ---- White balance ---- */

double np_preview_get_balance_share(double sun_elevation_deg) {
  return fmin(fmax((sun_elevation_deg - 5.0) / 10.0, 0.0), 1.0);
}

static bool get_number(const neph_image *image, const char *name, double *out) {
  const char *value = neph_image_get_attribute(image, name);
  if (value) *out = strtod(value, NULL);
  return value;
}

/* The white blends from D65 to the light of the meter. */
static void balance(const neph_image *image, np_preview_planes *planes) {
  static const double d65[2] = {0.3127, 0.3290};
  double xy[2], elevation;
  np_color_matrix matrix;
  if (!get_number(image, NP_EXPOSURE_METER_X, &xy[0]) || !get_number(image, NP_EXPOSURE_METER_Y, &xy[1]) ||
      !get_number(image, NP_EXPOSURE_SUN_ELEVATION, &elevation)) {
    np_log(image->context, NEPH_LOG_INFO, "preview: the picture states no light of the sun: no white balance");
    return;
  }
  const double share = np_preview_get_balance_share(elevation);
  for (int i = 0; i < 2; i++) xy[i] = d65[i] + share * (xy[i] - d65[i]);
  if (!np_color_space_adapt_white(xy, &matrix)) {
    np_log(image->context, NEPH_LOG_WARNING,
           "%s %g and %s %g are no chromaticity of a white, such as 0.33 and 0.35: the preview has no white balance",
           NP_EXPOSURE_METER_X, xy[0], NP_EXPOSURE_METER_Y, xy[1]);
    return;
  }
  np_log(image->context, NEPH_LOG_INFO, "preview: white balance for x %.4f, y %.4f", xy[0], xy[1]);
  if (share > 0.0) np_preview_append_matrix(planes, &matrix);
}

neph_result np_preview_prepare_camera(const neph_image *image, const neph_preview_desc *desc, bool is_parallel,
                                      np_preview_planes *planes) {
  const double pixel_rad = np_glare_get_pixel_rad(image);
  balance(image, planes);
  if (desc->glare <= 0.0) return NEPH_OK;
  if (pixel_rad > 0.0) return np_glare_create(image, desc->glare, pixel_rad, is_parallel, planes);
  np_log(image->context, NEPH_LOG_INFO, "preview: the picture has no matrix of a perspective camera: no glare");
  return NEPH_OK;
}
