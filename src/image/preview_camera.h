/* SPDX-License-Identifier: Apache-2.0 */
/* The view of a camera: white balance, glare and tone. */
#ifndef NP_IMAGE_PREVIEW_CAMERA_H
#define NP_IMAGE_PREVIEW_CAMERA_H

#include "image/preview_planes.h"

/* Tone of one exposed linear pixel: display light in [0, 1]. */
void np_preview_map_camera(const float exposed[3], float out_display[3]);

/* Share of a full white balance for a sun this far above the horizon: 0 below 5°, 1 above 15°. */
double np_preview_get_balance_share(double sun_elevation_deg);

/* Sets up the planes, which have their factor, by the header of the picture: the white balance, and the glare, which
 * np_glare_destroy frees. Logs which of them the picture has. */
neph_result np_preview_prepare_camera(const neph_image *image, const neph_preview_desc *desc, bool is_parallel,
                                      np_preview_planes *planes);

#endif
