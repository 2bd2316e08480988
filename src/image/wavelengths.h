/* SPDX-License-Identifier: Apache-2.0 */
/* Wavelengths that represent the visible spectrum, and weights by which their radiances add up to a colour.
 *
 * The range is cut into equal cells between 400 and 700 nm, of which the outermost reach to the ends of the matching
 * functions. A wavelength lies at its cell's centre of gravity under x + y + z, and represents the mean over the cell
 * of whatever is rough (the lines in the sun's spectrum, ozone's bands); what is left, the work of the air, is smooth.
 * Weights are the cell's integrals of x, y and z, corrected by the slope between neighbours for their centres of
 * gravity, which differ from the wavelength: exact for spectra that are linear from cell to cell.
 */
#ifndef NP_IMAGE_WAVELENGTHS_H
#define NP_IMAGE_WAVELENGTHS_H

enum { NP_WAVELENGTHS_MIN = 6, NP_WAVELENGTHS_MAX = 300 };

typedef struct np_wavelengths {
  unsigned count;
  double nm[NP_WAVELENGTHS_MAX];           /* ascending */
  double bound_nm[NP_WAVELENGTHS_MAX + 1]; /* bounds of the cells */
  double xyz_nm[NP_WAVELENGTHS_MAX][3];    /* X = Σ radiance · xyz_nm[i][0], and so on */
} np_wavelengths;

/* Chooses `count` wavelengths, NP_WAVELENGTHS_MIN to NP_WAVELENGTHS_MAX. */
void np_wavelengths_choose(unsigned count, np_wavelengths *out);

/* The mean of a spectrum over one cell, weighted by x + y + z. */
double np_wavelengths_mean(const np_wavelengths *wavelengths, unsigned index, double (*spectrum)(double nm));

#endif
