/* SPDX-License-Identifier: Apache-2.0 */
/* Tone mapping of a preview. */
#ifndef NP_IMAGE_PREVIEW_H
#define NP_IMAGE_PREVIEW_H

#include "image/image_private.h"

/* One linear pixel, exposed, to display light in [0, 1] by the filmic view. */
void np_preview_map_tone(const float exposed[3], float out_display[3]);

/* Renders an image into width·height·3 components of 8 or 16 bits. */
neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint16_t *out_rgb);

#endif
