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
 * The prior G, g are the same sums over skies of the Earth at three heights, the sun from 60° to −6°. They stand for
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

/* The cells of np_color_fit_choose_cells in which the bands lie, the longest first: those of a picture, then those
 * that probes have besides. */
extern const unsigned np_color_fit_cells[NP_COLOR_PROBE_BAND_COUNT];

/* Cells of 5 nm. */
void np_color_fit_choose_cells(np_wavelengths *out);

/* Sums over probes. */
typedef struct np_color_fit {
  double gram[9][9], right[9], weight;
} np_color_fit;

/* X, Y, Z by band: the sum of x[b] · at[b]. */
typedef struct np_color_weights {
  double at[NP_COLOR_BAND_COUNT][3];
} np_color_weights;

/* X, Y, Z (integrals over wavelength, in nm) of a probe's six bands, each over the sun's. */
void np_color_fit_compute_xyz(const double x[NP_COLOR_PROBE_BAND_COUNT], double out_xyz[3]);

/* Adds a probe by its weight; one without light is left out. */
void np_color_fit_add(np_color_fit *fit, const double x[NP_COLOR_BAND_COUNT], const double xyz[3], double weight);

/* Without probes: of the prior alone. */
void np_color_fit_solve(const np_color_fit *fit, np_color_weights *out);

/* The bands, over the sun's, that have a colour: the inverse of the weights. False where they span no space. */
bool np_color_weights_invert(const np_color_weights *weights, const double xyz[3], double out_x[NP_COLOR_BAND_COUNT]);

#endif
