/* SPDX-License-Identifier: Apache-2.0 */
/* White balance and glare of a preview by the header of its picture. */
#ifndef NP_IMAGE_PREVIEW_CAMERA_H
#define NP_IMAGE_PREVIEW_CAMERA_H

#include "image/preview_planes.h"

/* Share of a full white balance for sun and moon this far above the horizon: 0 below 5°, 1 above 15°. The moon counts
 * by night: in full with the sun at −18°, and not at all above −9°. Without a moon: −90°. */
double np_preview_get_balance_share(double sun_elevation_deg, double moon_elevation_deg);

/* Sets up the planes, which have their factor, by the header of the picture: the white balance, and the glare, which
 * np_glare_destroy frees. Logs which of them the picture lacks. */
neph_result np_preview_prepare_camera(const neph_image *image, const neph_preview_desc *desc, bool is_parallel,
                                      np_preview_planes *planes);

#endif
