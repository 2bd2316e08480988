/* SPDX-License-Identifier: Apache-2.0 */
/* Refractive indices of water and ice in air, in visible light. Absorption is left out: through a drop of 1 mm it is
 * below 5e-4. */
#ifndef NP_OPTICS_REFRACTION_H
#define NP_OPTICS_REFRACTION_H

/* Water at 20 °C, 182 to 1129 nm (Daimon and Masumura 2007, "Measurement of the refractive index of distilled water
 * from the near-infrared region to the ultraviolet region", table 2). */
double np_refraction_get_water(double wavelength_nm);

/* Ice, 400 to 700 nm, at the ends beyond; linear between the values of Warren and Brandt 2008, "Optical constants of
 * ice from the ultraviolet to the microwave". */
double np_refraction_get_ice(double wavelength_nm);

#endif
