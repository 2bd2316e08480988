/* SPDX-License-Identifier: Apache-2.0 */
/* The three spectral bands of one packet, and conversion of a scene's values to them.
 *
 * Scenes state values at 680, 550 and 440 nm, the reference bands. The rule of a value gives it in other bands:
 *
 * linear albedos, radiances: linear in wavelength between the reference bands, constant beyond;
 *
 * power scattering and absorption: a power of the wavelength, continued beyond;
 *
 * other values have a spectrum of their own, multiplied by the ratio of the scene's values to it: linear for the sun
 * and ozone, a power for molecules. So the default sun, ozone and air are the measured ones, and a scene's values hold
 * exactly in the reference bands. */
#ifndef NP_ATMOSPHERE_BAND_SET_H
#define NP_ATMOSPHERE_BAND_SET_H

#include <nephos/atmosphere.h>

#include "core/spectrum.h"
#include "image/wavelengths.h"

typedef enum np_band_rule {
  NP_BAND_LINEAR,
  NP_BAND_POWER,
  NP_BAND_SUN,
  NP_BAND_OZONE,
  NP_BAND_MOLECULES,
  NP_BAND_RULE_COUNT
} np_band_rule;

typedef struct np_band_set {
  bool is_reference;
  double nm[NP_BAND_COUNT];
  double shape[NP_BAND_RULE_COUNT][NP_BAND_COUNT]; /* spectra of the rules, as means over each band */
} np_band_set;

/* The reference bands at 680, 550 and 440 nm, in which scenes give their values. */
np_band_set np_band_set_reference(void);

/* Bands of packet `packet` of count/3: one from each third of the wavelengths, the longest first. */
np_band_set np_band_set_choose(const np_wavelengths *wavelengths, unsigned packet);

/* Bands of three wavelengths by index. */
np_band_set np_band_set_choose_cells(const np_wavelengths *wavelengths, const unsigned index[NP_BAND_COUNT]);

/* Index in `wavelengths` of a band of a packet. */
unsigned np_band_set_get_index(const np_wavelengths *wavelengths, unsigned packet, unsigned band);

/* Converts a scene's three values to these bands; not negative unless the scene's are. */
void np_band_set_convert(const np_band_set *bands, np_band_rule rule, const double reference[NP_BAND_COUNT],
                         double out[NP_BAND_COUNT]);

/* CIE X, Y and Z of a scene's three values: integrals over wavelength in nm. */
void np_band_set_compute_xyz(const np_wavelengths *wavelengths, np_band_rule rule,
                             const double reference[NP_BAND_COUNT], double out_xyz[3]);

/* Converts a layer of the air to these bands: molecules by their own spectrum, other coefficients as powers of the
 * wavelength, asymmetries linearly. Density tables stay unchanged. */
neph_atmosphere_layer np_band_set_convert_layer(const np_band_set *bands, const neph_atmosphere_layer *reference);

#endif
