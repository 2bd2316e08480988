/* SPDX-License-Identifier: Apache-2.0 */
/* Conversion of exposed light to preview components: tone curves, sRGB transfer function, dither. */
#ifndef NP_IMAGE_PREVIEW_TONE_H
#define NP_IMAGE_PREVIEW_TONE_H

#include <math.h>

#include "core/math.h"
#include "core/random.h"
#include "image/preview.h"
#include "image/preview_planes.h"

/* One row for each neph_view. */
typedef struct np_preview_view {
  void (*map)(const float exposed[3], float out_display[3]); /* display light in [0, 1]; NULL: by OpenColorIO */
  float (*encode)(float linear);                             /* component in [0, 1] of display light */
  float (*decode)(float component);                          /* the inverse of `encode` */
  float linear_until;                                        /* light up to which `map` only clips negative values */
  bool is_for_display;                                       /* whether exposure and conversion to Rec.709 apply */
  const char *name;
  bool is_camera; /* whether white balance and glare apply */
} np_preview_view;

const np_preview_view *np_preview_get_view(neph_view view);

/* Display light of an exposed pixel in the planes' primaries, whose colours are converted in place. */
static inline void np_preview_map(const np_preview_view *view, const np_preview_planes *planes, float exposed[3],
                                  float out_display[3]) {
  if (view->is_for_display) np_preview_convert(planes, exposed);
  if (view->map)
    view->map(exposed, out_display);
  else
    np_ocio_view_map(&planes->ocio, exposed, out_display);
}

/* Checks a caller's description, but not the names in a configuration of OpenColorIO. */
neph_result np_preview_check_desc(neph_context *context, const neph_preview_desc *desc);

/* Exposure factor on the values of the picture, white balance apart. */
neph_result np_preview_choose_factor(const neph_image *image, const neph_preview_desc *desc, double *out);

/* Chooses planes, exposure, white balance and glare of a picture whose description is checked. `is_parallel`: false
 * leaves the context's threads alone. np_preview_clear_planes frees them, after a failure too. */
neph_result np_preview_prepare(const neph_image *image, const neph_preview_desc *desc, neph_pixel_type pixel_type,
                               bool is_parallel, np_preview_planes *planes, double *out_exposure);
void np_preview_clear_planes(const neph_image *image, np_preview_planes *planes);

/* Three uniform numbers in [0, 1) for a pixel, from its place in the whole picture. */
static inline void np_preview_draw_uniform(int x, int y, float out[3]) {
  const uint64_t place = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
  uint64_t bits = np_random_mix(np_random_mix(place) + UINT64_C(0x9e3779b97f4a7c15));
  for (int c = 0; c < 3; c++) out[c] = (float)(bits >> 21 * c & 0x1fffffu) * 0x1p-21f;
}

/* Quantizes with dither: differences of neighbours' numbers, triangular over ±1 step, which hide banding at equal
 * noise, without low frequencies along the row. Dither fades out at black and white, where clipping would shift the
 * mean. */
static inline uint16_t np_preview_quantize(float encoded, float noise, float top) {
  float steps = encoded * top;
  float amplitude = np_minf(1.0f, np_minf(steps, top - steps));
  return (uint16_t)lrintf(np_clampf(steps + amplitude * noise, 0.0f, top));
}

#endif
