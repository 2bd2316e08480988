/* SPDX-License-Identifier: Apache-2.0 */
/* Sun and ozone are means over bins of 10 nm, constant in each bin, so that lines and bands within a bin are right in
 * the mean. At 680, 550 and 440 nm the sun has the default irradiances of scenes, and 300 Dobson units of ozone over 15
 * km their default absorption. */
#include "atmosphere/spectra.h"

#include <math.h>

enum { BIN_COUNT = 48 };
static const double first_nm = 360.0, bin_nm = 10.0;

/* ASTM G173-03, column ETR (Gueymard 2004, "The sun's total and spectral irradiance"). */
static const double sun[BIN_COUNT] = {
    1.11776, 1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.6887,  1.61253, 1.91198, 2.03474, 2.02042, 2.02212,
    1.93377, 1.95809, 1.91686, 1.8298,  1.8685,  1.8931,  1.85149, 1.8504,  1.8341,  1.8345,  1.8147,  1.78158,
    1.7533,  1.6965,  1.68194, 1.64654, 1.6048,  1.52143, 1.55622, 1.5113,  1.474,   1.4482,  1.41018, 1.36775,
    1.34188, 1.31429, 1.28303, 1.26758, 1.2367,  1.2082,  1.18737, 1.14683, 1.12362, 1.1058,  1.07124, 1.04992,
};

/* Serdyuchenko et al. 2014, "High spectral resolution ozone absorption cross-sections", part 2. */
static const double ozone[BIN_COUNT] = {
    1.18e-27,  2.182e-28, 2.818e-28, 6.636e-28, 1.527e-27, 2.763e-27, 5.52e-27,  8.451e-27, 1.582e-26, 2.316e-26,
    3.669e-26, 4.924e-26, 7.752e-26, 9.016e-26, 1.48e-25,  1.602e-25, 2.139e-25, 2.755e-25, 3.091e-25, 3.5e-25,
    4.266e-25, 4.672e-25, 4.398e-25, 4.701e-25, 5.019e-25, 4.305e-25, 3.74e-25,  3.215e-25, 2.662e-25, 2.238e-25,
    1.852e-25, 1.473e-25, 1.209e-25, 9.423e-26, 7.455e-26, 6.566e-26, 5.105e-26, 4.15e-26,  4.228e-26, 3.237e-26,
    2.451e-26, 2.801e-26, 2.534e-26, 1.624e-26, 1.465e-26, 2.078e-26, 1.383e-26, 7.105e-27,
};

static double read_bin(const double table[BIN_COUNT], double wavelength_nm) {
  return table[(int)fmin(fmax((wavelength_nm - first_nm) / bin_nm, 0.0), BIN_COUNT - 1)];
}

double np_spectra_sun(double wavelength_nm) { return read_bin(sun, wavelength_nm); }

double np_spectra_ozone(double wavelength_nm) { return read_bin(ozone, wavelength_nm); }

/* Bodhaine et al. 1999, "On Rayleigh optical depth calculations", equation 29: dispersion and depolarisation of dry air
 * with 360 ppm of carbon dioxide; good to 0.01 % from 250 to 850 nm. */
double np_spectra_molecules(double wavelength_nm) {
  const double square = 1e-6 * wavelength_nm * wavelength_nm; /* µm² */
  const double above = 1.0455996 - 341.29061 / square - 0.90230850 * square;
  const double below = 1.0 + 0.0027059889 / square - 85.968563 * square;
  return 1e-32 * above / below;
}
