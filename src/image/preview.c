/* SPDX-License-Identifier: Apache-2.0 */
/* Preview of radiance on a display: exposure, a view transform, sRGB, dither.
 *
 * The filmic view is linear where film is, so that creases of sunlit cloud keep their contrast, and has a shoulder
 * above: f(x) = x up to s = 3/4, then 1 − (1 − s)·e^{−(x − s)/(1 − s)}, of one slope. It is applied to the largest
 * component m, the others keep their ratio to it, and so their hue; light far above the shoulder fades to white by
 * (1 − f(m)/m)², as film and eye have it.
 */
#include "image/preview.h"

#include <nephos/exposure.h>

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/parallel.h"
#include "core/random.h"
#include "image/exposure.h"
#include "image/preview_planes.h"

/* ---- Tone ---- */

static const float shoulder = 0.75f;

static float apply_shoulder(float x) {
  if (x <= shoulder) return x;
  return 1.0f - (1.0f - shoulder) * expf((shoulder - x) / (1.0f - shoulder));
}

void np_preview_map_tone(const float exposed[3], float out_display[3]) {
  const float peak = fmaxf(exposed[0], fmaxf(exposed[1], exposed[2]));
  const float display = apply_shoulder(fmaxf(peak, 0.0f)), compression = peak > 0.0f ? display / peak : 1.0f;
  const float fade = (1.0f - compression) * (1.0f - compression);
  for (int c = 0; c < 3; c++) {
    const float kept_hue = fmaxf(exposed[c], 0.0f) * compression;
    out_display[c] = fminf(kept_hue + fade * (display - kept_hue), 1.0f);
  }
}

/* sRGB transfer function, IEC 61966-2-1. */
static float encode_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

static float encode_linear(float linear) { return linear; }

static void clip(const float exposed[3], float out_display[3]) {
  for (int c = 0; c < 3; c++) out_display[c] = fminf(fmaxf(exposed[c], 0.0f), 1.0f);
}

/* One row for each neph_view. */
typedef struct view_row {
  void (*map)(const float exposed[3], float out_display[3]);
  float (*encode)(float linear);
  bool is_for_display; /* whether exposure and conversion to Rec.709 apply */
  const char *name;
} view_row;

static const view_row views[] = {[NEPH_VIEW_FILMIC] = {np_preview_map_tone, encode_srgb, true, "filmic"},
                                 [NEPH_VIEW_STANDARD] = {clip, encode_srgb, true, "standard"},
                                 [NEPH_VIEW_RAW] = {clip, encode_linear, false, "raw"}};

enum { VIEW_COUNT = sizeof views / sizeof *views };

/* ---- Dither ---- */

/* Three uniform numbers in [0, 1) for a pixel, from its place in the whole picture. */
static void draw_uniform(int x, int y, float out[3]) {
  const uint64_t place = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
  uint64_t bits = np_random_mix(np_random_mix(place) + UINT64_C(0x9e3779b97f4a7c15));
  for (int c = 0; c < 3; c++) out[c] = (float)(bits >> 21 * c & 0x1fffffu) * 0x1p-21f;
}

/* Quantizes with dither: differences of neighbours' numbers, triangular over ±1 step, which hide banding at equal
 * noise, without low frequencies along the row. Dither fades out at black and white, where clipping would shift the
 * mean. */
static uint16_t quantize(float encoded, float noise, float top) {
  float steps = encoded * top;
  float amplitude = fminf(1.0f, fminf(steps, top - steps));
  return (uint16_t)lrintf(fminf(fmaxf(steps + amplitude * noise, 0.0f), top));
}

/* ---- Pixels ---- */

typedef struct preview_job {
  const neph_image *image;
  np_preview_planes planes;
  const view_row *view;
  float top; /* greatest value of a component */
  uint16_t *rgb;
  atomic_size_t nan_count;
} preview_job;

static void paint(uint16_t *rgb, float r, float g, float b) {
  rgb[0] = (uint16_t)r, rgb[1] = (uint16_t)g, rgb[2] = (uint16_t)b;
}

static void render_pixel(preview_job *job, float exposed[3], const float noise[3], uint16_t *rgb) {
  float display[3];
  if (isnan(exposed[0]) || isnan(exposed[1]) || isnan(exposed[2])) {
    atomic_fetch_add(&job->nan_count, 1);
    paint(rgb, job->top, 0.0f, job->top);
  } else if (fmaxf(exposed[0], fmaxf(exposed[1], exposed[2])) == HUGE_VALF) {
    paint(rgb, job->top, job->top, job->top);
  } else {
    if (job->view->is_for_display) np_preview_convert(&job->planes, exposed);
    job->view->map(exposed, display);
    for (int c = 0; c < 3; c++) rgb[c] = quantize(job->view->encode(display[c]), noise[c], job->top);
  }
}

static void render_row(preview_job *job, size_t y) {
  size_t width = job->image->width;
  const int left = np_image_get_data_min(job->image, 0), row = np_image_get_data_min(job->image, 1) + (int)y;
  float here[3], right[3];
  draw_uniform(left, row, here);
  for (size_t x = 0; x < width; x++) {
    float exposed[3], noise[3];
    size_t i = y * width + x;
    draw_uniform(left + (int)x + 1, row, right);
    np_preview_get_pixel(&job->planes, i, exposed);
    for (int c = 0; c < 3; c++) noise[c] = here[c] - right[c];
    render_pixel(job, exposed, noise, job->rgb + 3 * i);
    memcpy(here, right, sizeof here);
  }
}

static neph_result render_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t y = begin; y < end; y++) render_row(user, y);
  return NEPH_OK;
}

static neph_result check_desc(neph_context *context, const neph_preview_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (!(fabs(desc->exposure_ev) <= 64))
    return np_fail(context, bad, "preview exposure is %g stops, must be in [-64, 64]", desc->exposure_ev);
  if ((unsigned)desc->exposure > NEPH_EXPOSURE_CAMERA)
    return np_fail(context, bad, "preview exposure is %d, must be auto (0), meter (1), fixed (2) or camera (3)",
                   (int)desc->exposure);
  if ((unsigned)desc->pixel_type > NEPH_PIXEL_FLOAT)
    return np_fail(context, bad, "preview pixel_type is %d, must be half (0) or float (1)", (int)desc->pixel_type);
  if ((unsigned)desc->view >= VIEW_COUNT)
    return np_fail(context, bad, "preview view is %d, must be filmic (0), standard (1) or raw (2)", (int)desc->view);
  if (desc->bits != 8 && desc->bits != 16)
    return np_fail(context, bad, "preview bits are %u, must be 8 or 16", desc->bits);
  for (int c = 0; c < 3; c++)
    if (!(desc->white[c] > 0) || !isfinite(desc->white[c]))
      return np_fail(context, bad, "preview white of %c is %g, must be finite and above 0", "RGB"[c], desc -> white[c]);
  return NEPH_OK;
}

/* Exposure factor on the values of the picture, white balance apart. */
static neph_result choose_factor(const neph_image *image, const neph_preview_desc *desc, double *out) {
  neph_result result = NEPH_OK;
  double base = 1.0;
  if (views[desc->view].is_for_display) result = np_exposure_choose(image, desc, &base);
  *out = base * exp2(desc->exposure_ev);
  return result;
}

neph_result neph_image_compute_exposure(const neph_image *image, const neph_preview_desc *desc, double *out_stops) {
  const neph_preview_desc defaults = NEPH_PREVIEW_DESC_DEFAULT;
  neph_preview_desc wanted;
  double factor = 1.0;
  if (NP_LACKS(NP_CONTEXT_OF(image), out_stops)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(image->context, "neph_preview_desc", &defaults, sizeof defaults, desc, &wanted);
  if (!result) result = check_desc(image->context, &wanted);
  if (!result) result = choose_factor(image, &wanted, &factor);
  if (!result) *out_stops = log2(factor);
  return result;
}

const char *np_preview_name_view(neph_view view) { return views[view].name; }

neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint16_t *out_rgb,
                              double *out_exposure_ev) {
  double exposure;
  neph_result result = check_desc(image->context, desc);
  if (result) return result;
  preview_job job = {
      .image = image, .view = &views[desc->view], .top = (float)((1u << desc->bits) - 1u), .rgb = out_rgb};
  if (!np_preview_get_planes(image, desc->pixel_type, &job.planes))
    return np_fail(image->context, NEPH_ERROR_INVALID_ARGUMENT, "a preview needs the channels R, G and B, or Y");
  result = choose_factor(image, desc, &exposure);
  *out_exposure_ev = result ? 0.0 : log2(exposure);
  if (!result) np_log(image->context, NEPH_LOG_INFO, "preview: exposed by %+.2f EV", log2(exposure));
  for (int c = 0; c < 3; c++)
    job.planes.factor[c] = (float)(job.view->is_for_display ? exposure / desc->white[c] : exposure);
  if (!result) result = np_parallel_for(image->context, NULL, image->height, 8, render_rows, &job);
  size_t nan_count = atomic_load(&job.nan_count);
  if (nan_count)
    np_log(image->context, NEPH_LOG_WARNING, "%zu pixels are NaN, shown in magenta in the preview", nan_count);
  return result;
}
