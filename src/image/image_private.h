/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of an image. */
#ifndef NP_IMAGE_IMAGE_PRIVATE_H
#define NP_IMAGE_IMAGE_PRIVATE_H

#include <nephos/image.h>

#include "core/context_private.h"

typedef struct np_image_channel {
  char *name;
  float *values; /* width·height */
} np_image_channel;

typedef struct np_image_attribute {
  char *name, *value;
} np_image_attribute;

/* Typed header entries of a rendered picture; written to EXR when their flag is set. */
typedef struct np_image_header {
  bool has_camera;
  float world_to_camera[16], world_to_ndc[16]; /* row-vector convention of OpenEXR's standard attributes: p·M */
  bool has_chromaticities;
  float chromaticities[8];
  bool has_window; /* display window differs from the data window: crops and tiles */
  int data_min[2], data_max[2], display_min[2], display_max[2]; /* inclusive */
} np_image_header;

struct neph_image {
  neph_context *context;
  unsigned width, height; /* of the data window */
  unsigned channel_count, attribute_count;
  np_image_channel *channels;
  np_image_attribute *attributes;
  np_image_header header;
};

#endif
