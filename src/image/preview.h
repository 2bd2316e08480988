/* SPDX-License-Identifier: Apache-2.0 */
/* Tone mapping of a preview. */
#ifndef NP_IMAGE_PREVIEW_H
#define NP_IMAGE_PREVIEW_H

#include "image/image_private.h"

/* The exposure that the automatic choice gives, a factor on radiance over white; 1 for a picture without light. */
double np_preview_choose_exposure(const neph_image *image, const double white[3]);

/* One linear pixel, exposed, to display light in [0, 1]: 0.18 becomes 0.2, 16 becomes 1. */
void np_preview_map_tone(const float exposed[3], float out_display[3]);

/* Renders an image as 8-bit sRGB, three bytes a pixel, into width·height·3 bytes. */
neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint8_t *out_rgb);

#endif
