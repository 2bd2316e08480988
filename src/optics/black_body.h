/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance of a black body (Planck 1901, "Über das Gesetz der Energieverteilung im Normalspectrum"):
 *
 *     B(λ, T) = 2hc²/λ⁵ / (e^{hc/λkT} − 1)
 *
 * with the constants that define the SI since 2019. */
#ifndef NP_OPTICS_BLACK_BODY_H
#define NP_OPTICS_BLACK_BODY_H

#include "core/spectrum.h"

/* W m⁻² sr⁻¹ nm⁻¹; 0 at 0 K and below. */
double np_black_body_radiance(double wavelength_nm, double temperature_k);

/* The law in one packet's bands. */
typedef struct np_black_body {
  float front[NP_BAND_COUNT];      /* 2hc²/λ⁵, W m⁻² sr⁻¹ nm⁻¹ */
  float exponent_k[NP_BAND_COUNT]; /* hc/λk */
} np_black_body;

np_black_body np_black_body_make(const double wavelength_nm[NP_BAND_COUNT]);

/* The radiance is below a float's range where e^{hc/λkT} would overflow. */
static inline np_spectrum np_black_body_eval(const np_black_body *body, float temperature_k) {
  np_spectrum radiance = np_spectrum_grey(0.0f);
  if (!(temperature_k > 0.0f)) return radiance;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float x = body->exponent_k[b] / temperature_k;
    if (x < 80.0f) radiance.band[b] = body->front[b] / expm1f(x);
  }
  return radiance;
}

#endif
