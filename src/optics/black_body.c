/* SPDX-License-Identifier: Apache-2.0 */
#include "optics/black_body.h"

/* CODATA 2018, exact by the definition of the units. */
static const double planck_j_s = 6.62607015e-34;
static const double light_m_s = 299792458.0;
static const double boltzmann_j_k = 1.380649e-23;

static double compute_front(double wavelength_nm) {
  const double m = wavelength_nm * 1e-9;
  return 2.0 * planck_j_s * light_m_s * light_m_s / (m * m * m * m * m) * 1e-9;
}

static double compute_exponent_k(double wavelength_nm) {
  return planck_j_s * light_m_s / (wavelength_nm * 1e-9 * boltzmann_j_k);
}

double np_black_body_radiance(double wavelength_nm, double temperature_k) {
  if (!(temperature_k > 0.0)) return 0.0;
  return compute_front(wavelength_nm) / expm1(compute_exponent_k(wavelength_nm) / temperature_k);
}

np_black_body np_black_body_make(const double wavelength_nm[NP_BAND_COUNT]) {
  np_black_body body = {.has_factor = false};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    body.front[b] = (float)compute_front(wavelength_nm[b]);
    body.exponent_k[b] = (float)compute_exponent_k(wavelength_nm[b]);
  }
  return body;
}

double np_black_body_get_knot_k(int knot) { return np_black_body_knots_per_k / (knot > 0 ? knot : 0.01); }
