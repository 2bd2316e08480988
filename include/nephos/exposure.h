/* SPDX-License-Identifier: Apache-2.0 */
/* The exposure of a preview, computed without writing one. */
#ifndef NEPHOS_EXPOSURE_H
#define NEPHOS_EXPOSURE_H

#include <nephos/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Brightening of a preview in stops, white balance apart: base exposure plus exposure_ev.
 *
 * @param desc       NULL for the defaults.
 * @param out_stops  unchanged on failure.
 */
NEPH_API neph_result neph_image_compute_exposure(const neph_image *image, const neph_preview_desc *desc,
                                                 double *out_stops) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
