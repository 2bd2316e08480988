/* SPDX-License-Identifier: Apache-2.0 */
/* The views of a preview.
 *
 * The filmic view is linear where film is, so that creases of sunlit cloud keep their contrast, and has a shoulder
 * above: f(x) = x up to s = 3/4, then 1 − (1 − s)·e^{−(x − s)/(1 − s)}, of one slope. It is applied to the largest
 * component m, the others keep their ratio to it, and so their hue; light far above the shoulder fades to white by
 * (1 − f(m)/m)², as film and eye have it.
 *
 * The camera's view first multiplies by 1 + (2^0.45 − 1) · 2r/(1 + r²), r = m/0.22, a bell in stops, which lifts
 * midtones by 0.45 stops and black by none. Saturation is raised by 1.12 about the luminance, as far as no component
 * becomes negative. Both keep the dominant wavelength.
 */
#include "image/preview_tone.h"

#include "image/exposure.h"
#include "image/glare.h"
#include "image/preview_camera.h"

/* ---- Tone ---- */

static const float shoulder = 0.75f;

static float apply_shoulder(float x) {
  if (x <= shoulder) return x;
  return 1.0f - (1.0f - shoulder) * expf((shoulder - x) / (1.0f - shoulder));
}

void np_preview_map_tone(const float exposed[3], float out_display[3]) {
  const float peak = np_maxf(exposed[0], np_maxf(exposed[1], exposed[2]));
  const float display = apply_shoulder(np_maxf(peak, 0.0f)), compression = peak > 0.0f ? display / peak : 1.0f;
  const float fade = (1.0f - compression) * (1.0f - compression);
  for (int c = 0; c < 3; c++) {
    const float kept_hue = np_maxf(exposed[c], 0.0f) * compression;
    out_display[c] = np_minf(kept_hue + fade * (display - kept_hue), 1.0f);
  }
}

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
  for (int c = 0; c < 3; c++) rgb[c] = np_minf(np_maxf(exposed[c], 0.0f), 1e30f);
  saturate(rgb);
  const float peak = np_maxf(rgb[0], np_maxf(rgb[1], rgb[2])), factor = lift(np_minf(peak, 1e9f));
  for (int c = 0; c < 3; c++) rgb[c] *= factor;
  np_preview_map_tone(rgb, out_display);
}

/* sRGB transfer function, IEC 61966-2-1. */
static float encode_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

static float decode_srgb(float component) {
  return component <= 0.04045f ? component / 12.92f : powf((component + 0.055f) / 1.055f, 2.4f);
}

static float encode_linear(float linear) { return linear; }

static void clip(const float exposed[3], float out_display[3]) {
  for (int c = 0; c < 3; c++) out_display[c] = np_minf(np_maxf(exposed[c], 0.0f), 1.0f);
}

static const np_preview_view views[] = {
    [NEPH_VIEW_FILMIC] = {np_preview_map_tone, encode_srgb, decode_srgb, 0.75f, true, "filmic"},
    [NEPH_VIEW_STANDARD] = {clip, encode_srgb, decode_srgb, 1.0f, true, "standard"},
    [NEPH_VIEW_RAW] = {clip, encode_linear, encode_linear, 1.0f, false, "raw"},
    [NEPH_VIEW_CAMERA] = {np_preview_map_camera, encode_srgb, decode_srgb, -1.0f, true, "camera", true},
    [NEPH_VIEW_OCIO] = {NULL, encode_linear, encode_linear, -1.0f, true, "ocio"}};

enum { VIEW_COUNT = sizeof views / sizeof *views };

const np_preview_view *np_preview_get_view(neph_view view) { return &views[view]; }

const char *np_preview_name_view(neph_view view) { return views[view].name; }

/* ---- Descriptions ---- */

neph_result np_preview_check_desc(neph_context *context, const neph_preview_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (!(fabs(desc->exposure_ev) <= 64))
    return np_fail(context, bad, "preview exposure is %g stops, must be in [-64, 64]", desc->exposure_ev);
  if ((unsigned)desc->exposure > NEPH_EXPOSURE_CAMERA)
    return np_fail(context, bad, "preview exposure is %d, must be auto (0), meter (1), fixed (2) or camera (3)",
                   (int)desc->exposure);
  if ((unsigned)desc->pixel_type > NEPH_PIXEL_FLOAT)
    return np_fail(context, bad, "preview pixel_type is %d, must be half (0) or float (1)", (int)desc->pixel_type);
  if ((unsigned)desc->view >= VIEW_COUNT)
    return np_fail(context, bad,
                   "preview view is %d, must be filmic (0), standard (1), raw (2), camera (3) or ocio (4)",
                   (int)desc->view);
  if (desc->view == NEPH_VIEW_OCIO && (!desc->ocio_config || !*desc->ocio_config))
    return np_fail(context, bad, "preview view is ocio, which needs ocio_config, a configuration of OpenColorIO");
  if (!(desc->glare >= 0.0 && desc->glare <= 0.5))
    return np_fail(context, bad, "preview glare is %g, must be a share in [0, 0.5]", desc->glare);
  if (desc->bits != 8 && desc->bits != 16)
    return np_fail(context, bad, "preview bits are %u, must be 8 or 16", desc->bits);
  for (int c = 0; c < 3; c++)
    if (!(desc->white[c] > 0) || !isfinite(desc->white[c]))
      return np_fail(context, bad, "preview white of %c is %g, must be finite and above 0", "RGB"[c], desc -> white[c]);
  return NEPH_OK;
}

neph_result np_preview_choose_factor(const neph_image *image, const neph_preview_desc *desc, double *out) {
  neph_result result = NEPH_OK;
  double base = 1.0;
  if (views[desc->view].is_for_display) result = np_exposure_choose(image, desc, &base);
  *out = base * exp2(desc->exposure_ev);
  return result;
}

neph_result np_preview_prepare(const neph_image *image, const neph_preview_desc *desc, neph_pixel_type pixel_type,
                               bool is_parallel, np_preview_planes *planes, double *out_exposure) {
  const np_preview_view *view = &views[desc->view];
  *out_exposure = 1.0;
  if (!np_preview_get_planes(image, pixel_type, planes))
    return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT, "a preview needs the channels R, G and B, or Y");
  const neph_result result = np_preview_choose_factor(image, desc, out_exposure);
  if (result) return result;
  for (int c = 0; c < 3; c++)
    planes->factor[c] = (float)(view->is_for_display ? *out_exposure / desc->white[c] : *out_exposure);
  if (!view->map) return np_ocio_view_open(image->context, desc, &planes->ocio);
  return view->is_camera ? np_preview_prepare_camera(image, desc, is_parallel, planes) : NEPH_OK;
}

void np_preview_clear_planes(const neph_image *image, np_preview_planes *planes) {
  np_glare_destroy(image, planes);
  np_ocio_view_close(&planes->ocio);
}
