/* SPDX-License-Identifier: Apache-2.0 */
/* Colour spaces of a picture: bands as they are, or linear light of three primaries whose (1, 1, 1) is D65.
 *
 * Luminance is in units of that of 1 W m⁻² sr⁻¹ nm⁻¹ at every wavelength, 683 lm/W · ∫y dλ = 72,983 cd/m², so that
 * colours are about as large as their radiances.
 */
#ifndef NP_IMAGE_COLOR_SPACE_H
#define NP_IMAGE_COLOR_SPACE_H

#include "image/image_private.h"

typedef enum np_color_space {
  NP_COLOR_BANDS, /* R, G, B are the radiances in three bands */
  NP_COLOR_REC709,
  NP_COLOR_ACESCG,
  NP_COLOR_REC2020,
  NP_COLOR_XYZ, /* X, Y, Z of CIE 1931 unchanged: (0.9505, 1, 1.0891) is D65 */
  NP_COLOR_SPACE_COUNT
} np_color_space;

/* Matrix by rows: out[r] = Σ at[r][c] · in[c]. */
typedef struct np_color_matrix {
  double at[3][3];
} np_color_matrix;

/* Name of a space: "nephos-bands", "rec709", "acescg", "rec2020", "xyz". */
const char *np_color_space_get_name(np_color_space space);

/* Chromaticities x, y of red, green, blue and white in the order of OpenEXR; not for NP_COLOR_BANDS. */
const float *np_color_space_get_chromaticities(np_color_space space);

/* Matrix from XYZ, white at D65, to linear R, G, B. For a space with another white (ACEScg: x 0.32168, y 0.33767)
 * colours are adapted by the Bradford transform; X, Y, Z are not. Not for NP_COLOR_BANDS. */
np_color_matrix np_color_space_from_xyz(np_color_space space);

/* R, G and B of a radiance of 1 W m⁻² sr⁻¹ nm⁻¹ at a wavelength with weights `xyz_nm`. */
void np_color_space_weigh(np_color_space space, const double xyz_nm[3], double out_rgb[3]);

/* Matrix from linear R, G, B of a picture's chromaticities to Rec.709, with the picture's white adapted to D65. False
 * when the chromaticities are degenerate. */
bool np_color_space_to_rec709(const float chromaticities[8], np_color_matrix *out_rec709_from_rgb);

/* Shares of R, G and B of a picture's chromaticities in its luminance, 1 in all. False when the chromaticities are
 * degenerate. */
bool np_color_space_get_luminances(const float chromaticities[8], double out[3]);

/* Chromaticity x, y of a colour of Rec.709 with a luminance above 0. */
void np_color_space_get_chromaticity(const double rec709[3], double out_xy[2]);

/* Matrix in Rec.709 that shows a white of this chromaticity as D65, of the same luminance, by the Bradford transform.
 * False when no white has it: the response of a cone is not positive. */
bool np_color_space_adapt_white(const double xy[2], np_color_matrix *out);

/* Luminance of (1, 1, 1) in cd/m². */
double np_color_space_white_luminance(void);

#endif
