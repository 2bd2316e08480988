/* SPDX-License-Identifier: Apache-2.0 */
#include "image/preview_planes.h"

#include <string.h>

/* Chooses the primaries: Rec.709 where the header names none, as in OpenEXR, and for pictures of bands. */
void np_preview_choose_primaries(const neph_image *image, np_preview_planes *out) {
  const float *own = image->header.chromaticities;
  const float *rec709 = np_color_space_get_chromaticities(NP_COLOR_REC709);
  np_color_matrix matrix;
  out->has_primaries = image->header.has_chromaticities && memcmp(own, rec709, sizeof image->header.chromaticities) &&
                       np_color_space_to_rec709(own, &matrix);
  for (int r = 0; out->has_primaries && r < 3; r++)
    for (int c = 0; c < 3; c++) out->rec709_from_rgb[r][c] = (float)matrix.at[r][c];
}

void np_preview_append_matrix(np_preview_planes *planes, const np_color_matrix *matrix) {
  float before[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (planes->has_primaries) memcpy(before, planes->rec709_from_rgb, sizeof before);
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) {
      double sum = 0.0;
      for (int k = 0; k < 3; k++) sum += matrix->at[r][k] * (double)before[k][c];
      planes->rec709_from_rgb[r][c] = (float)sum;
    }
  planes->has_primaries = true;
}

void np_preview_convert(const np_preview_planes *planes, float rgb[3]) {
  if (!planes->has_primaries) return;
  const float own[3] = {rgb[0], rgb[1], rgb[2]};
  for (int r = 0; r < 3; r++) {
    const float *row = planes->rec709_from_rgb[r];
    rgb[r] = row[0] * own[0] + row[1] * own[1] + row[2] * own[2];
  }
}

bool np_preview_get_planes(const neph_image *image, neph_pixel_type wanted, np_preview_planes *out) {
  static const char *const colours[3] = {"R", "G", "B"};
  out->veil = NULL;
  out->ocio = (np_ocio_view){NULL, NULL};
  for (int c = 0; c < 3; c++) {
    out->plane[c] = neph_image_get_values(image, colours[c]);
    if (!out->plane[c]) out->plane[c] = neph_image_get_values(image, "Y");
    if (!out->plane[c]) return false;
  }
  np_preview_choose_primaries(image, out);
  out->are_halves = np_image_get_pixel_type(image, wanted) == NEPH_PIXEL_HALF;
  return true;
}
