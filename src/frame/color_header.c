/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/color_header.h"

#include <string.h>

#include "core/text.h"

/* "680 nm, 550 nm, 440 nm", the longest first. */
static void list_wavelengths(const np_assembly *assembly, char *out, size_t size) {
  size_t length = 0;
  for (unsigned b = 0; b < NP_BAND_COUNT; b++)
    for (unsigned p = 0; p < assembly->packet_count && length < size; p++)
      length +=
          np_print(out + length, size - length, "%s%.5g nm", length ? ", " : "", assembly->packets[p].bands.nm[b]);
}

static neph_result write_bands(double scale, neph_image *image) {
  char white[96];
  np_print(white, sizeof white, "(1, 1, 1) is a radiance of %g W m^-2 sr^-1 nm^-1 in each band", 1.0 / scale);
  return neph_image_set_attribute(image, "nephos:white", white);
}

static neph_result write_space(np_color_space space, double scale, neph_image *image) {
  const double luminance = np_color_space_white_luminance() / scale;
  char white[160];
  np_print(white, sizeof white, "%s is D65 of %.6g cd m^-2, the luminance of %g W m^-2 sr^-1 nm^-1 at every wavelength",
           space == NP_COLOR_XYZ ? "(0.9505, 1, 1.089)" : "(1, 1, 1)", luminance, 1.0 / scale);
  memcpy(image->header.chromaticities, np_color_space_get_chromaticities(space), sizeof image->header.chromaticities);
  image->header.has_chromaticities = true;
  neph_result result = neph_image_set_attribute(image, "nephos:white", white);
  return result ? result : np_image_set_real(image, "whiteLuminance", luminance);
}

/* Writes the matrix from the bands, the longest wavelength first, to R, G and B; its inverse recovers the bands. */
static neph_result write_matrix(const np_assembly *assembly, neph_image *image) {
  char text[200];
  size_t length = 0;
  for (int i = 0; i < 3 * NP_BAND_COUNT; i++)
    length += np_print(text + length, sizeof text - length, "%s%.7g",
                       i == 0  ? ""
                       : i % 3 ? " "
                               : " / ",
                       (double)assembly->packets[0].color_weight[i / 3][i % 3]);
  return neph_image_set_attribute(image, "nephos:bandMatrix", text);
}

neph_result np_color_header_write(const np_plan *plan, const np_assembly *assembly, double scale, neph_image *image) {
  char wavelengths[NP_WAVELENGTHS_MAX * 12];
  list_wavelengths(assembly, wavelengths, sizeof wavelengths);
  const bool is_bands = plan->decisions.color_space == NP_COLOR_BANDS;
  neph_result result =
      neph_image_set_attribute(image, "nephos:colorSpace", np_color_space_get_name(plan->decisions.color_space));
  if (!result) result = neph_image_set_attribute(image, is_bands ? "nephos:bands" : "nephos:wavelengths", wavelengths);
  if (!result) result = neph_image_set_attribute(image, "nephos:unit", "W m^-2 sr^-1 nm^-1");
  if (!result) result = np_image_set_real(image, "nephos:scale", scale);
  if (!result && assembly->color.is_fitted) result = write_matrix(assembly, image);
  if (result) return result;
  return is_bands ? write_bands(scale, image) : write_space(plan->decisions.color_space, scale, image);
}
