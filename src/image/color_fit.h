/* SPDX-License-Identifier: Apache-2.0 */
/* Colours from three bands: the matrix from radiances at 612.5, 537.5 and 447.5 nm to X, Y, Z.
 *
 * A band counts as its radiance over the sun's there, x. Three of these hold nearly all that the eye sees of sunlight
 * and skylight; the matrix that gets most out of them is fitted to a scene's own light: probes, each with its x and its
 * X, Y, Z, make a least-squares problem of colour differences. Each probe is scaled to Y = 0.4 and weighs by Q = JᵀJ, J
 * the Jacobian of CIE 1976 L*a*b* there (white D65):
 *
 *     (mean(x xᵀ ⊗ Q) + 0.1·G) a = mean(x ⊗ Q X) + 0.1·g
 *
 * The prior G, g are the same sums over skies of the Earth at three heights, the sun from 60° to −6°. They represent
 * what the probes leave open, and alone they give the best fixed matrix.
 *
 * X, Y, Z of a probe come of six bands, these three and 652.4, 552.5, 432.6 nm, by weights that were fitted to such
 * skies against 60 wavelengths: ΔE*ab is 0.06 in the mean, 0.27 at most.
 */
#ifndef NP_IMAGE_COLOR_FIT_H
#define NP_IMAGE_COLOR_FIT_H

#include <stdbool.h>

#include "image/wavelengths.h"

enum { NP_COLOR_BAND_COUNT = 3, NP_COLOR_PROBE_BAND_COUNT = 6 };

/* Cells of np_color_fit_choose_cells with the bands, the longest wavelength first: bands of a picture, then the
 * additional bands of probes. */
extern const unsigned np_color_fit_cells[NP_COLOR_PROBE_BAND_COUNT];

/* Chooses cells of 5 nm. */
void np_color_fit_choose_cells(np_wavelengths *out);

/* Normal equations: sums over probes. */
typedef struct np_color_fit {
  double gram[9][9], right[9], weight;
} np_color_fit;

/* Weights X, Y, Z of each band: the sum of x[b] · at[b]. */
typedef struct np_color_weights {
  double at[NP_COLOR_BAND_COUNT][3];
} np_color_weights;

/* X, Y, Z (integrals over wavelength, in nm) from a probe's six bands, each over the sun's. */
void np_color_fit_compute_xyz(const double x[NP_COLOR_PROBE_BAND_COUNT], double out_xyz[3]);

/* Adds a probe with its weight; a probe without light is left out. */
void np_color_fit_add(np_color_fit *fit, const double x[NP_COLOR_BAND_COUNT], const double xyz[3], double weight);

/* Solves for the weights; without probes the prior alone decides. */
void np_color_fit_solve(const np_color_fit *fit, np_color_weights *out);

/* Band radiances, relative to the sun's, of a colour X, Y, Z: the inverse of the weights. False where they are
 * singular. */
bool np_color_weights_invert(const np_color_weights *weights, const double xyz[3], double out_x[NP_COLOR_BAND_COUNT]);

#endif
