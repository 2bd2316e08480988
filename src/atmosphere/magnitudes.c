/* SPDX-License-Identifier: Apache-2.0 */
/* Zero points of the Johnson-Cousins bands: Bessell, Castelli and Plez 1998, "Model Atmospheres, Broad-band Colors, ...
 * for O-M Stars", A&A 333, table A2: effective wavelength of an A0 star, and irradiance of magnitude 0.
 *
 * A star's B and V fix a black body, which gives the rest of its spectrum. It ignores the Balmer jump and the bands of
 * cool stars: for Vega the error at 680 nm is 6 %. */
#include "atmosphere/magnitudes.h"

#include "core/math.h"

const double np_passband_wavelength_nm[NP_PASSBAND_COUNT] = {366.0, 438.0, 545.0, 641.0, 798.0};

/* 1e-9 erg cm⁻² s⁻¹ Å⁻¹ is 1e-11 W m⁻² nm⁻¹. */
static const double zero_irradiance[NP_PASSBAND_COUNT] = {4.175e-11, 6.32e-11, 3.631e-11, 2.177e-11, 1.126e-11};

/* Second radiation constant, nm·K. */
static const double second_constant = 1.438777e7;

double np_magnitude_irradiance(np_passband passband, double magnitude) {
  return zero_irradiance[passband] * pow(10.0, -0.4 * magnitude);
}

/* Ratio of Planck's law at two wavelengths. `x` = c₂/T, nm. */
static double compute_ratio(double wavelength_nm, double to_nm, double x) {
  const double r = to_nm / wavelength_nm;
  return r * r * r * r * r * expm1(x / to_nm) / expm1(x / wavelength_nm);
}

/* c₂/T of the black body with a given ratio of B to V, which decreases with c₂/T from its limit for infinite
 * temperature. */
static double search_temperature_term(double ratio) {
  double hot = 1.0, cold = second_constant / 1000.0;
  for (int i = 0; i < 60; i++) {
    const double x = 0.5 * (hot + cold);
    const bool is_bluer =
        compute_ratio(np_passband_wavelength_nm[NP_PASSBAND_B], np_passband_wavelength_nm[NP_PASSBAND_V], x) > ratio;
    *(is_bluer ? &hot : &cold) = x;
  }
  return 0.5 * (hot + cold);
}

np_spectrum np_star_irradiance(double v_magnitude, double b_minus_v, const double wavelength_nm[NP_BAND_COUNT]) {
  const double v = np_magnitude_irradiance(NP_PASSBAND_V, v_magnitude);
  const double b = np_magnitude_irradiance(NP_PASSBAND_B, v_magnitude + b_minus_v), x = search_temperature_term(b / v);
  np_spectrum out;
  for (int i = 0; i < NP_BAND_COUNT; i++)
    out.band[i] = (float)(v * compute_ratio(wavelength_nm[i], np_passband_wavelength_nm[NP_PASSBAND_V], x));
  return out;
}
