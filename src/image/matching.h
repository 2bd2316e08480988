/* SPDX-License-Identifier: Apache-2.0 */
/* The colour matching functions of the CIE 1931 standard observer (2 degrees), linear between their values at every
 * 5 nm, 0 outside 360 to 830 nm. */
#ifndef NP_IMAGE_MATCHING_H
#define NP_IMAGE_MATCHING_H

#include <stdbool.h>
#include <stddef.h>

enum { NP_MATCHING_FIRST_NM = 360, NP_MATCHING_LAST_NM = 830 };

/* Lumens per watt of light at 540 THz, nearly the peak of y. */
#define NP_LUMENS_PER_WATT 683.0

void np_matching_eval(double wavelength_nm, double out_xyz[3]);

/* x + y + z, the weight of a wavelength in a colour. */
double np_matching_sum(double wavelength_nm);

/* The integral of y, 106.86 nm. */
double np_matching_luminous_width_nm(void);

#endif
