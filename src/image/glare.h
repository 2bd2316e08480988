/* SPDX-License-Identifier: Apache-2.0 */
/* Veiling glare of a camera: light that lens and sensor scatter over the whole picture. */
#ifndef NP_IMAGE_GLARE_H
#define NP_IMAGE_GLARE_H

#include "image/preview_planes.h"

/* Scattered light of the planes' picture, and the share of light that stays in its pixel. Light of a point is spread by
 *
 *     PSF(θ) ∝ ∫ σ^−2.2 · e^(−a²/2σ² − σ²/2b²) · G(θ; σ) dln σ,   about θ^−2.2 from a = 0.03° to b = 20°,
 *
 * the integral over normalized Gaussians G taken an octave apart, each a level of a pyramid: the ripple over the power
 * law is 1 %. Gaussians below the pixel leave light in it. Light that leaves the picture comes back, as from a picture
 * mirrored at its borders, and so a constant picture stays as it is and no light is lost. Pixels that are not finite,
 * and negative ones, scatter nothing.
 *
 * `share` of all light is scattered; `pixel_rad` is the angle of a pixel. `is_parallel`: false leaves the context's
 * threads alone, for calls while they work. Sets `veil`, which np_glare_destroy frees, and `kept_share`.
 */
neph_result np_glare_create(const neph_image *image, double share, double pixel_rad, bool is_parallel,
                            np_preview_planes *planes);
void np_glare_destroy(const neph_image *image, np_preview_planes *planes);

/* Angle of a pixel in the middle of a perspective picture by the matrices of its header; 0: it has none. */
double np_glare_get_pixel_rad(const neph_image *image);

#endif
