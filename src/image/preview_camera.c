/* SPDX-License-Identifier: Apache-2.0 */
/* White balance and glare of a preview by the header of its picture. */
#include "image/preview_camera.h"

#include <math.h>
#include <stdlib.h>

#include "image/exposure.h"
#include "image/glare.h"

/* Goes from 0 at one value to 1 at another. */
static double compute_ramp(double value, double zero, double one) {
  return fmin(fmax((value - zero) / (one - zero), 0.0), 1.0);
}

double np_preview_get_balance_share(double sun_elevation_deg, double moon_elevation_deg) {
  const double night = compute_ramp(sun_elevation_deg, -9.0, -18.0);
  return fmax(compute_ramp(sun_elevation_deg, 5.0, 15.0), night * compute_ramp(moon_elevation_deg, 5.0, 15.0));
}

static bool get_number(const neph_image *image, const char *name, double *out) {
  const char *value = neph_image_get_attribute(image, name);
  if (value) *out = strtod(value, NULL);
  return value;
}

/* The white blends from D65 to the light of the meter. */
static void balance(const neph_image *image, np_preview_planes *planes) {
  static const double d65[2] = {0.3127, 0.3290};
  double xy[2], elevation, moon_elevation = -90.0;
  np_color_matrix matrix;
  if (!get_number(image, NP_EXPOSURE_METER_X, &xy[0]) || !get_number(image, NP_EXPOSURE_METER_Y, &xy[1]) ||
      !get_number(image, NP_EXPOSURE_SUN_ELEVATION, &elevation)) {
    np_log(image->context, NEPH_LOG_INFO, "preview: the picture states no light of the sun: no white balance");
    return;
  }
  (void)get_number(image, NP_EXPOSURE_MOON_ELEVATION, &moon_elevation);
  const double share = np_preview_get_balance_share(elevation, moon_elevation);
  for (int i = 0; i < 2; i++) xy[i] = d65[i] + share * (xy[i] - d65[i]);
  if (!np_color_space_adapt_white(xy, &matrix)) {
    np_log(image->context, NEPH_LOG_WARNING,
           "%s %g and %s %g are no chromaticity of a white, such as 0.33 and 0.35: the preview has no white balance",
           NP_EXPOSURE_METER_X, xy[0], NP_EXPOSURE_METER_Y, xy[1]);
    return;
  }
  if (share > 0.0) np_preview_append_matrix(planes, &matrix);
}

neph_result np_preview_prepare_camera(const neph_image *image, const neph_preview_desc *desc, bool is_parallel,
                                      np_preview_planes *planes) {
  const double pixel_rad = np_glare_get_pixel_rad(image);
  balance(image, planes);
  if (desc->glare <= 0.0) return NEPH_OK;
  if (pixel_rad > 0.0) return np_glare_create(image, desc->glare, pixel_rad, is_parallel, planes);
  np_log(image->context, NEPH_LOG_INFO, "preview: the picture has no matrix of a perspective camera: no glare");
  return NEPH_OK;
}
