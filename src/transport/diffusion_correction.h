/* SPDX-License-Identifier: Apache-2.0 */
/* Diffusion synthetic acceleration of the sweeps: the slow part of what is still missing from a solution. */
#ifndef NP_TRANSPORT_DIFFUSION_CORRECTION_H
#define NP_TRANSPORT_DIFFUSION_CORRECTION_H

#include "transport/diffusion_system.h"

/* Adds the correction to the mean radiance in `image`, the moments [active][harmonic] of a sweep from `x`. Same bits
 * for any number of threads. */
void np_diffusion_correct(np_diffusion *diffusion, const float *x, float *image);

#endif
