/* SPDX-License-Identifier: Apache-2.0 */
/* The exposure of a preview, apart from writing one. */
#ifndef NEPHOS_EXPOSURE_H
#define NEPHOS_EXPOSURE_H

#include <nephos/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Stops by which a preview shows a picture brighter than its values, white apart: base exposure and exposure_ev.
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
