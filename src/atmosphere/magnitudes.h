/* SPDX-License-Identifier: Apache-2.0 */
/* Astronomers' magnitudes, as irradiances. */
#ifndef NP_ATMOSPHERE_MAGNITUDES_H
#define NP_ATMOSPHERE_MAGNITUDES_H

#include "core/spectrum.h"

typedef enum np_passband { NP_PASSBAND_U, NP_PASSBAND_B, NP_PASSBAND_V, NP_PASSBAND_R, NP_PASSBAND_I } np_passband;
enum { NP_PASSBAND_COUNT = 5 };

/* The middles of the bands. */
extern const double np_passband_wavelength_nm[NP_PASSBAND_COUNT];

/* Irradiance of a magnitude at the middle of its band, W m⁻² nm⁻¹. */
double np_magnitude_irradiance(np_passband passband, double magnitude);

/* Irradiance of a star above the atmosphere: its spectrum is a black body's whose B − V is the star's. */
np_spectrum np_star_irradiance(double v_magnitude, double b_minus_v, const double wavelength_nm[NP_BAND_COUNT]);

#endif
