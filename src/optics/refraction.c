/* SPDX-License-Identifier: Apache-2.0 */
#include "optics/refraction.h"

#include <math.h>

/* Refractive index of air at sea level. */
static const double air = 1.000277;

/* Sellmeier's equation, in a vacuum: n² = 1 + Σ A·λ²/(λ² − B), B in µm². */
double np_refraction_get_water(double wavelength_nm) {
  static const double strength[4] = {5.684027565e-1, 1.726177391e-1, 2.086189578e-2, 1.130748688e-1};
  static const double resonance_um2[4] = {5.101829712e-3, 1.821153936e-2, 2.620722293e-2, 1.069792721e1};
  const double square = wavelength_nm * wavelength_nm * 1e-6;
  double sum = 1.0;
  for (int i = 0; i < 4; i++) sum += strength[i] * square / (square - resonance_um2[i]);
  return sqrt(sum) / air;
}

double np_refraction_get_ice(double wavelength_nm) {
  static const double index[] = {1.3194, 1.3157, 1.3130, 1.3110, 1.3094, 1.3081, 1.3070};
  const double place = fmin(fmax((wavelength_nm - 400.0) / 50.0, 0.0), 6.0);
  const int low = place < 5.0 ? (int)place : 5;
  return index[low] + (place - low) * (index[low + 1] - index[low]);
}
