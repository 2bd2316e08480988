/* SPDX-License-Identifier: Apache-2.0 */
/* The three bands of one packet, and what a scene's values are in them.
 *
 * A scene says everything at 680, 550 and 440 nm, the reference bands. In other bands
 *   linear   albedos, radiances: linear in wavelength between the reference bands, constant beyond;
 *   power    scattering and absorption: a power of the wavelength between them, which goes on beyond;
 *   the rest has a spectrum of its own, and the ratio of the scene's values to it goes as above: linear for the sun and
 *            ozone, as a power for molecules.
 * So the default sun, ozone and air are the measured ones, and a scene's values hold exactly in its own bands.
 */
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
  double shape[NP_BAND_RULE_COUNT][NP_BAND_COUNT]; /* the rules' own spectra, means over each band */
} np_band_set;

/* 680, 550 and 440 nm, where every value is the scene's. */
np_band_set np_band_set_reference(void);

/* Packet `packet` of count/3: one band of each third of the wavelengths, the longest first. */
np_band_set np_band_set_choose(const np_wavelengths *wavelengths, unsigned packet);

/* The bands of three wavelengths by their indices. */
np_band_set np_band_set_choose_cells(const np_wavelengths *wavelengths, const unsigned index[NP_BAND_COUNT]);

/* The index in `wavelengths` of a band of a packet. */
unsigned np_band_set_get_index(const np_wavelengths *wavelengths, unsigned packet, unsigned band);

/* A scene's three values in these bands; never negative where the scene's are not. */
void np_band_set_convert(const np_band_set *bands, np_band_rule rule, const double reference[NP_BAND_COUNT],
                         double out[NP_BAND_COUNT]);

/* X, Y and Z, integrals over wavelength in nm, of a scene's three values. */
void np_band_set_compute_xyz(const np_wavelengths *wavelengths, np_band_rule rule,
                             const double reference[NP_BAND_COUNT], double out_xyz[3]);

/* A layer of the air in these bands: molecules scatter by their own spectrum, all else as a power of the wavelength;
 * asymmetries are linear. A table stays where it is. */
neph_atmosphere_layer np_band_set_convert_layer(const np_band_set *bands, const neph_atmosphere_layer *reference);

#endif
