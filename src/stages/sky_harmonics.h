/* SPDX-License-Identifier: Apache-2.0 */
/* Spherical harmonics of order 2 of light that comes from everywhere.
 *
 * Real, orthonormal, without the Condon-Shortley phase (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
 * Irradiance Environment Maps"), x east, y north, z up, direction away from the observer:
 *
 *   Y0 = 1/(2√π);  Y1, Y2, Y3 = √(3/4π)·(y, z, x);
 *   Y4, Y5, Y7 = √(15/4π)·(xy, yz, xz);  Y6 = √(5/16π)·(3z² − 1);  Y8 = √(15/16π)·(x² − y²).
 *
 * The k-th coefficient is ∫ L·Yk dω.
 */
#ifndef NP_STAGES_SKY_HARMONICS_H
#define NP_STAGES_SKY_HARMONICS_H

#include "core/math.h"
#include "core/spectrum.h"

enum { NP_SKY_HARMONICS = 9 };

typedef np_spectrum (*np_radiance_fn)(const void *user, np_vec3 direction);

/* Integrates over the sphere with the midpoint rule on a grid of directions, half of them above the horizon. */
void np_sky_harmonics_project(np_radiance_fn radiance, const void *user, double out[NP_SKY_HARMONICS][NP_BAND_COUNT]);

/* Yk of a direction. */
void np_sky_harmonics_eval(np_vec3 direction, double out[NP_SKY_HARMONICS]);

#endif
