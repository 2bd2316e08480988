/* SPDX-License-Identifier: Apache-2.0 */
/* Tone mapping of a preview. */
#ifndef NP_IMAGE_PREVIEW_H
#define NP_IMAGE_PREVIEW_H

#include "image/image_private.h"

/* Filmic tone mapping of one exposed linear pixel to display light in [0, 1]. */
void np_preview_map_tone(const float exposed[3], float out_display[3]);

/* The same by a camera, of lifted midtones. */
void np_preview_map_camera(const float exposed[3], float out_display[3]);

/* Renders an image into width·height·3 components of 8 or 16 bits. */
neph_result np_preview_render(const neph_image *image, const neph_preview_desc *desc, uint16_t *out_rgb,
                              double *out_exposure_ev);

/* Name of a view in output.view. */
const char *np_preview_name_view(neph_view view);

/* Texts that mark a preview's file. */
#define NP_PREVIEW_FRAME "nephos:frame"
#define NP_PREVIEW_EXPOSURE "nephos:exposure" /* stops from values to display light */
#define NP_PREVIEW_VIEW "nephos:view"

/* Describes a .png with these texts. NULL, with NEPH_OK: it has none, or is no PNG. */
neph_result np_preview_describe_file(neph_context *context, const char *path, neph_text_format format, char **out_text);

#endif
