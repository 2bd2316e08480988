/* SPDX-License-Identifier: Apache-2.0 */
/* A picture that the program nephos_pictures decodes: OpenEXR and libpng believe files, and one that is made for it may
 * overwrite their memory. In a process of its own, which may open no file and has limits on memory and time, it gets no
 * further. */
#ifndef NP_IMAGE_PICTURE_PROCESS_H
#define NP_IMAGE_PICTURE_PROCESS_H

#include "image/image_private.h"

typedef struct np_picture_request {
  const char *word;    /* of picture_stream.h */
  const char *path;    /* of the picture */
  const char *program; /* in place of nephos_pictures, for tests; NULL: that */
} np_picture_request;

/* Gives a file to the program and reads its answer, of which every number is checked. `out_info` may be NULL, as may
 * the monitor. */
neph_result np_picture_read(neph_context *context, const np_picture_request *request, np_monitor *monitor,
                            np_image_exr_info *out_info, neph_image **out_image);

#endif
