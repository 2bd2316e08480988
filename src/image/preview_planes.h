/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of a preview, and their colours. */
#ifndef NP_IMAGE_PREVIEW_PLANES_H
#define NP_IMAGE_PREVIEW_PLANES_H

#include "core/half.h"
#include "image/color_space.h"
#include "image/image_private.h"
#include "image/ocio_view.h"

/* The three planes of a preview; all the same for a grey picture. */
typedef struct np_preview_planes {
  const float *plane[3];
  bool are_halves; /* values are rounded to halves, as in a file */
  float factor[3]; /* exposure over white */
  bool has_primaries;
  float rec709_from_rgb[3][3]; /* matrix for primaries other than Rec.709's, and for a white balance */
  float *veil;                 /* scattered light of the planes' pixels, R, G, B; NULL: none */
  float kept_share;            /* share of a pixel's light that a veil leaves in it */
  np_ocio_view ocio;           /* open for NEPH_VIEW_OCIO alone */
} np_preview_planes;

/* Chooses the planes. False for an image that has neither R, G and B nor Y. Leaves `factor` unset. Values are rounded
 * to halves where a file of the wanted type has halves. */
bool np_preview_get_planes(const neph_image *image, neph_pixel_type wanted, np_preview_planes *out);

/* A pixel times `factor`, with its veil. */
static inline void np_preview_get_pixel(const np_preview_planes *planes, size_t pixel, float out_rgb[3]) {
  for (int c = 0; c < 3; c++) {
    const float value = planes->plane[c][pixel];
    out_rgb[c] = (planes->are_halves ? np_half_to_float(np_half_from_float(value)) : value) * planes->factor[c];
    if (planes->veil) out_rgb[c] = planes->kept_share * out_rgb[c] + planes->veil[3 * pixel + (size_t)c];
  }
}

/* Fills the primaries alone. */
void np_preview_choose_primaries(const neph_image *image, np_preview_planes *out);

/* Appends a matrix in Rec.709 that is applied after the conversion of primaries. */
void np_preview_append_matrix(np_preview_planes *planes, const np_color_matrix *matrix);

/* Converts a pixel from the planes' primaries to Rec.709, in place. */
void np_preview_convert(const np_preview_planes *planes, float rgb[3]);

#endif
