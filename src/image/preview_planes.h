/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of an image that are shown, and their colours. */
#ifndef NP_IMAGE_PREVIEW_PLANES_H
#define NP_IMAGE_PREVIEW_PLANES_H

#include "image/image_private.h"

/* The three planes shown; all the same for a grey picture. */
typedef struct np_preview_planes {
  const float *plane[3];
  float factor[3]; /* exposure over white */
  bool has_primaries;
  float rec709_from_rgb[3][3]; /* of primaries that are not Rec.709's */
} np_preview_planes;

/* False for an image that has neither R, G and B nor Y. Leaves `factor` unset. */
bool np_preview_get_planes(const neph_image *image, np_preview_planes *out);

/* Fills the primaries alone. */
void np_preview_choose_primaries(const neph_image *image, np_preview_planes *out);

/* A pixel of the planes' primaries to Rec.709, in place. */
void np_preview_convert(const np_preview_planes *planes, float rgb[3]);

#endif
