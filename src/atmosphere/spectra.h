/* SPDX-License-Identifier: Apache-2.0 */
/* Tabulated spectra, which are not smooth between the three bands of a scene. */
#ifndef NP_ATMOSPHERE_SPECTRA_H
#define NP_ATMOSPHERE_SPECTRA_H

/* Solar irradiance above the atmosphere, W m⁻² nm⁻¹, 360 to 840 nm; clamped outside. */
double np_spectra_sun(double wavelength_nm);

/* Absorption cross section of ozone at 233 K, m², 360 to 840 nm; clamped outside. */
double np_spectra_ozone(double wavelength_nm);

/* Rayleigh scattering cross section of a molecule of air, m². */
double np_spectra_molecules(double wavelength_nm);

#endif
