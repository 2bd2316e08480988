/* SPDX-License-Identifier: Apache-2.0 */
/* Radiance of a black body (Planck 1901, "Über das Gesetz der Energieverteilung im Normalspectrum"):
 *
 *     B(λ, T) = 2hc²/λ⁵ / (e^{hc/λkT} − 1)
 *
 * with the constants that define the SI since 2019. */
#ifndef NP_OPTICS_BLACK_BODY_H
#define NP_OPTICS_BLACK_BODY_H

#include <stdint.h>

#include "core/spectrum.h"

/* Radiance in W m⁻² sr⁻¹ nm⁻¹; 0 at 0 K and below. */
double np_black_body_radiance(double wavelength_nm, double temperature_k);

enum { NP_BLACK_BODY_KNOTS = 129 };
static const double np_black_body_knots_per_k = 64e3; /* knots are even in 1/T, from 0 to 1/500 K */

/* Planck's law in one packet's bands. Where three bands represent a spectrum, a factor on each, linear between knots,
 * gives emission the colour of the body. */
typedef struct np_black_body {
  float front[NP_BAND_COUNT];      /* 2hc²/λ⁵, W m⁻² sr⁻¹ nm⁻¹ */
  float exponent_k[NP_BAND_COUNT]; /* hc/λk */
  int32_t has_factor;              /* 0 or 1; not bool, so that bodies have no padding and can be hashed as bytes */
  float factor[NP_BLACK_BODY_KNOTS][NP_BAND_COUNT];
} np_black_body;

/* Temperature at a knot; high, but finite, at the first. */
double np_black_body_get_knot_k(int knot);

np_black_body np_black_body_make(const double wavelength_nm[NP_BAND_COUNT]);

static inline np_spectrum np_black_body_get_factor(const np_black_body *body, float temperature_k) {
  const float place = fminf((float)np_black_body_knots_per_k / temperature_k, NP_BLACK_BODY_KNOTS - 1.0f);
  const int knot = (int)fminf(place, NP_BLACK_BODY_KNOTS - 2.0f);
  const float *low = body->factor[knot], *high = body->factor[knot + 1], t = place - (float)knot;
  return np_spectrum_make(low[0] + t * (high[0] - low[0]), low[1] + t * (high[1] - low[1]),
                          low[2] + t * (high[2] - low[2]));
}

/* Radiance per band. It is below a float's range where e^{hc/λkT} would overflow. */
static inline np_spectrum np_black_body_eval(const np_black_body *body, float temperature_k) {
  np_spectrum radiance = np_spectrum_grey(0.0f);
  if (!(temperature_k > 0.0f)) return radiance;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float x = body->exponent_k[b] / temperature_k;
    if (x < 80.0f) radiance.band[b] = body->front[b] / expm1f(x);
  }
  return body->has_factor ? np_spectrum_multiply(radiance, np_black_body_get_factor(body, temperature_k)) : radiance;
}

#endif
