/* SPDX-License-Identifier: Apache-2.0 */
/* The exposure of a preview, and its pixels in memory, without a file. */
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

/** Develops a rectangle of a picture, x0 ≤ x < x1 and y0 ≤ y < y1, into 8-bit pixels: the components of its .png
 * (neph_image_save_png) without its dither, and so within one step of the file's.
 *
 * Any picture with R, G and B, or Y, will do, an unfinished one too, such as the image of a neph_tile_fn. A base
 * exposure by the picture (NEPH_EXPOSURE_AUTO) goes by all of its pixels: neph_image_compute_exposure returns it, and
 * NEPH_EXPOSURE_FIXED with that number as exposure_ev holds it. Calls for one picture may run at the same time.
 *
 * @param desc    NULL for the defaults; its bits and pixel_type are not used: components have 8 bits, values are
 * floats.
 * @param x0, y0  first column and row, from the top left corner of the picture.
 * @param x1, y1  the column and the row behind the last, at most width and height.
 * @param rgba    (y1 − y0) rows of (x1 − x0) pixels of four bytes: sRGB (of NEPH_VIEW_RAW: linear) R, G, B, and 255.
 * @param stride  bytes from a row to the next, at least 4·(x1 − x0).
 */
NEPH_API neph_result neph_image_develop(const neph_image *image, const neph_preview_desc *desc, unsigned x0,
                                        unsigned y0, unsigned x1, unsigned y1, uint8_t *rgba,
                                        size_t stride) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif
