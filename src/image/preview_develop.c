/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels of a preview in memory. A component is the nearest of 255 steps to the transfer function of the view: a table
 * over the bits of display light, 128 cells an octave, has the step at the beginning of a cell, and a cell holds one
 * limit between two steps at most. */
#include <nephos/exposure.h>

#include <math.h>
#include <string.h>

#include "core/given.h"
#include "image/preview_planes.h"
#include "image/preview_tone.h"

/* ---- The transfer function as a table ---- */

enum {
  OCTAVES = 13, /* number of octaves; below 2⁻¹³ every view is black */
  CELL_BITS = 7,
  CELL_SHIFT = 23 - CELL_BITS,
  CELLS = OCTAVES << CELL_BITS,
  FIRST_CELL = (127 - OCTAVES) << CELL_BITS, /* upper bits of 2⁻¹³ */
  STEPS = 255
};

typedef struct encoding {
  float limit[STEPS + 1]; /* linear display value half a step above each step; infinite for the last */
  uint8_t step[CELLS + 1];
} encoding;

static float get_light(unsigned cell) {
  const uint32_t bits = (uint32_t)(FIRST_CELL + cell) << CELL_SHIFT;
  float light;
  memcpy(&light, &bits, sizeof light);
  return light;
}

static void fill_encoding(const np_preview_view *view, encoding *out) {
  uint8_t step = 0;
  for (int i = 0; i < STEPS; i++) out->limit[i] = view->decode(((float)i + 0.5f) / STEPS);
  out->limit[STEPS] = HUGE_VALF;
  for (unsigned cell = 0; cell <= CELLS; cell++) {
    while (get_light(cell) >= out->limit[step]) step++;
    out->step[cell] = step;
  }
}

/* A component of display light up to 1; 0 for negative light. */
static inline uint8_t encode(const encoding *table, float display) {
  int32_t bits;
  memcpy(&bits, &display, sizeof bits);
  if (bits < FIRST_CELL << CELL_SHIFT) return 0;
  const uint8_t step = table->step[(bits >> CELL_SHIFT) - FIRST_CELL];
  return (uint8_t)(step + (display >= table->limit[step]));
}

/* ---- Pixels ---- */

typedef struct rectangle {
  unsigned x0, y0, x1, y1;
} rectangle;

typedef struct development {
  const neph_image *image;
  const np_preview_view *view;
  np_preview_planes planes;
  encoding encoding;
} development;

static void paint(uint8_t rgba[4], uint8_t r, uint8_t g, uint8_t b) { rgba[0] = r, rgba[1] = g, rgba[2] = b; }

/* Paints a pixel with NaN or an infinite value in a marking colour; false: the pixel is finite. */
static inline bool paint_odd(const float exposed[3], uint8_t rgba[4]) {
  const bool is_nan = isnan(exposed[0]) || isnan(exposed[1]) || isnan(exposed[2]);
  const bool is_infinite = np_maxf(exposed[0], np_maxf(exposed[1], exposed[2])) == HUGE_VALF;
  if (is_nan)
    paint(rgba, 255, 0, 255);
  else if (is_infinite)
    paint(rgba, 255, 255, 255);
  return is_nan || is_infinite;
}

/* Develops any pixel: odd values (NaN, infinite) in marking colours, others by the tone curve. */
static void develop_by_curve(const development *d, size_t pixel, uint8_t rgba[4]) {
  float exposed[3], display[3];
  np_preview_get_pixel(&d->planes, pixel, exposed);
  if (paint_odd(exposed, rgba)) return;
  np_preview_map(d->view, &d->planes, exposed, display);
  for (int c = 0; c < 3; c++) rgba[c] = encode(&d->encoding, display[c]);
}

static inline bool is_linear(const development *d, const float exposed[3]) {
  const float end = d->view->linear_until;
  return exposed[0] <= end && exposed[1] <= end && exposed[2] <= end;
}

static void develop_row(const development *d, size_t pixel, size_t count, uint8_t *rgba) {
  const bool is_converted = d->view->is_for_display && d->planes.has_primaries;
  for (const size_t end = pixel + count; pixel < end; pixel++, rgba += 4) {
    float exposed[3];
    np_preview_get_pixel(&d->planes, pixel, exposed);
    if (is_converted) np_preview_convert(&d->planes, exposed);
    if (is_linear(d, exposed))
      for (int c = 0; c < 3; c++) rgba[c] = encode(&d->encoding, exposed[c]);
    else
      develop_by_curve(d, pixel, rgba);
    rgba[3] = 255;
  }
}

static neph_result check_rectangle(const neph_image *image, const rectangle *r, size_t stride) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (r->x0 >= r->x1 || r->y0 >= r->y1 || r->x1 > image->width || r->y1 > image->height)
    return np_fail(image->context, bad,
                   "columns %u to %u and rows %u to %u are no rectangle of a picture of %u × %u pixels", r->x0, r->x1,
                   r->y0, r->y1, image->width, image->height);
  if (stride < 4 * (size_t)(r->x1 - r->x0))
    return np_fail(image->context, bad, "the stride is %zu bytes, must be at least 4 for each of %u pixels", stride,
                   r->x1 - r->x0);
  return NEPH_OK;
}

neph_result neph_image_develop(const neph_image *image, const neph_preview_desc *desc, unsigned x0, unsigned y0,
                               unsigned x1, unsigned y1, uint8_t *rgba, size_t stride) {
  const neph_preview_desc defaults = NEPH_PREVIEW_DESC_DEFAULT;
  const rectangle wanted = {x0, y0, x1, y1};
  neph_preview_desc read;
  development d = {.image = image};
  double exposure;
  if (NP_LACKS(NP_CONTEXT_OF(image), rgba)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = np_desc_read(image->context, "neph_preview_desc", &defaults, sizeof defaults, desc, &read);
  if (!result) result = np_preview_check_desc(image->context, &read);
  if (!result) result = check_rectangle(image, &wanted, stride);
  if (result) return result;
  d.view = np_preview_get_view(read.view);
  fill_encoding(d.view, &d.encoding);
  result = np_preview_prepare(image, &read, NEPH_PIXEL_FLOAT, false, &d.planes, &exposure);
  for (unsigned y = y0; y < y1 && !result; y++)
    develop_row(&d, (size_t)y * image->width + x0, x1 - x0, rgba + (y - y0) * stride);
  np_preview_clear_planes(image, &d.planes);
  return result;
}
