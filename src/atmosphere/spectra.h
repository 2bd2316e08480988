/* SPDX-License-Identifier: Apache-2.0 */
/* Spectra that are not smooth, or steep, between the three bands of a scene. */
#ifndef NP_ATMOSPHERE_SPECTRA_H
#define NP_ATMOSPHERE_SPECTRA_H

/* Sunlight above the atmosphere, W m⁻² nm⁻¹, 360 to 840 nm; the nearest end outside. */
double np_spectra_sun(double wavelength_nm);

/* Ozone's absorption cross section at 233 K, m², 360 to 840 nm; the nearest end outside. */
double np_spectra_ozone(double wavelength_nm);

/* The Rayleigh scattering cross section of a molecule of air, m². */
double np_spectra_molecules(double wavelength_nm);

#endif
