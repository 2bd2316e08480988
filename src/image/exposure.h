/* SPDX-License-Identifier: Apache-2.0 */
/* Exposure of a preview, a factor on radiance over white. */
#ifndef NP_IMAGE_EXPOSURE_H
#define NP_IMAGE_EXPOSURE_H

#include "image/image_private.h"

/* Attributes of a render for the meter: luminance of a white diffuser that faces the light, in the units of the picture
 * and in cd/m². */
#define NP_EXPOSURE_METER "nephos:meter"
#define NP_EXPOSURE_METER_LUMINANCE "nephos:meterLuminance"

/* Chromaticity of that diffuser, for the white balance; and degrees of sun and moon above the horizon. */
#define NP_EXPOSURE_METER_X "nephos:meterX"
#define NP_EXPOSURE_METER_Y "nephos:meterY"
#define NP_EXPOSURE_SUN_ELEVATION "nephos:sunElevation"
#define NP_EXPOSURE_MOON_ELEVATION "nephos:moonElevation"

/* Exposure value at ISO 100 of a camera with f-stop, shutter and ISO. */
#define NP_EXPOSURE_EV100 "nephos:EV100"

/* Luminance of one colour of a picture, 1 for its (1, 1, 1). */
double np_exposure_get_luminance(const neph_image *image, const float rgb[3]);

/* The same colour in Rec.709. */
void np_exposure_convert(const neph_image *image, const float rgb[3], double out_rec709[3]);

/* Chooses the exposure. Fails for meter and camera where the picture lacks their attributes. */
neph_result np_exposure_choose(const neph_image *image, const neph_preview_desc *desc, double *out_factor);

/* Automatic exposure by the picture; 1 for a picture without light. */
double np_exposure_choose_by_picture(const neph_image *image, const neph_preview_desc *desc);

#endif
