/* SPDX-License-Identifier: Apache-2.0 */
/* Preview of radiance on a display: exposure, a view, dither. */
#include "image/preview.h"

#include <nephos/exposure.h>

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/parallel.h"
#include "image/preview_planes.h"
#include "image/preview_tone.h"

/* ---- Pixels ---- */

typedef struct preview_job {
  const neph_image *image;
  np_preview_planes planes;
  const np_preview_view *view;
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
  } else if (np_maxf(exposed[0], np_maxf(exposed[1], exposed[2])) == HUGE_VALF) {
    paint(rgb, job->top, job->top, job->top);
  } else {
    np_preview_map(job->view, &job->planes, exposed, display);
    for (int c = 0; c < 3; c++) rgb[c] = np_preview_quantize(job->view->encode(display[c]), noise[c], job->top);
  }
}

static void render_row(preview_job *job, size_t y) {
  size_t width = job->image->width;
  const int left = np_image_get_data_min(job->image, 0), row = np_image_get_data_min(job->image, 1) + (int)y;
  float here[3], right[3];
  np_preview_draw_uniform(left, row, here);
  for (size_t x = 0; x < width; x++) {
    float exposed[3], noise[3];
    size_t i = y * width + x;
    np_preview_draw_uniform(left + (int)x + 1, row, right);
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

neph_result neph_image_compute_exposure(const neph_image *image, const neph_preview_desc *desc, double *out_stops) {
  const neph_preview_desc defaults = NEPH_PREVIEW_DESC_DEFAULT;
  neph_preview_desc wanted;
  double factor = 1.0;
  if (NP_LACKS(NP_CONTEXT_OF(image), out_stops)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(image->context, "neph_preview_desc", &defaults, sizeof defaults, desc, &wanted);
  if (!result) result = np_preview_check_desc(image->context, &wanted);
  if (!result) result = np_preview_choose_factor(image, &wanted, &factor);
  if (!result) *out_stops = log2(factor);
  return result;
}

neph_result neph_preview_check(neph_context *context, const neph_preview_desc *desc) {
  const neph_preview_desc defaults = NEPH_PREVIEW_DESC_DEFAULT;
  neph_preview_desc wanted;
  np_ocio_view opened = {NULL, NULL};
  if (!context) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(context, "neph_preview_desc", &defaults, sizeof defaults, desc, &wanted);
  if (!result) result = np_preview_check_desc(context, &wanted);
  if (!result && wanted.view == NEPH_VIEW_OCIO) result = np_ocio_view_open(context, &wanted, &opened);
  np_ocio_view_close(&opened);
  return result;
}

neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint16_t *out_rgb,
                              double *out_exposure_ev) {
  double exposure;
  neph_result result = np_preview_check_desc(image->context, desc);
  if (result) return result;
  preview_job job = {
      .image = image, .view = np_preview_get_view(desc->view), .top = (float)((1u << desc->bits) - 1u), .rgb = out_rgb};
  result = np_preview_prepare(image, desc, desc->pixel_type, true, &job.planes, &exposure);
  *out_exposure_ev = result ? 0.0 : log2(exposure);
  if (!result) np_log(image->context, NEPH_LOG_INFO, "preview: exposed by %+.2f EV", log2(exposure));
  if (!result) result = np_parallel_for(image->context, NULL, image->height, 8, render_rows, &job);
  np_preview_clear_planes(image, &job.planes);
  size_t nan_count = atomic_load(&job.nan_count);
  if (nan_count)
    np_log(image->context, NEPH_LOG_WARNING, "%zu pixels are NaN, shown in magenta in the preview", nan_count);
  return result;
}
