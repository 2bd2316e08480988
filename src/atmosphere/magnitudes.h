/* SPDX-License-Identifier: Apache-2.0 */
/* Conversion of astronomical magnitudes to irradiances. */
#ifndef NP_ATMOSPHERE_MAGNITUDES_H
#define NP_ATMOSPHERE_MAGNITUDES_H

#include "core/spectrum.h"

typedef enum np_passband { NP_PASSBAND_U, NP_PASSBAND_B, NP_PASSBAND_V, NP_PASSBAND_R, NP_PASSBAND_I } np_passband;
enum { NP_PASSBAND_COUNT = 5 };

/* Effective wavelengths of the passbands. */
extern const double np_passband_wavelength_nm[NP_PASSBAND_COUNT];

/* Irradiance of a magnitude at the effective wavelength of its passband, W m⁻² nm⁻¹. */
double np_magnitude_irradiance(np_passband passband, double magnitude);

/* Irradiance of a star above the atmosphere. Its spectrum is a black body with the star's B − V. */
np_spectrum np_star_irradiance(double v_magnitude, double b_minus_v, const double wavelength_nm[NP_BAND_COUNT]);

#endif
