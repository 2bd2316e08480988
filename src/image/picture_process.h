/* SPDX-License-Identifier: Apache-2.0 */
/* Decoding of pictures in a process of its own, the program nephos_pictures: OpenEXR and libpng trust files, and a
 * crafted file may overwrite their memory. That process may open no file and has limits on memory and time. */
#ifndef NP_IMAGE_PICTURE_PROCESS_H
#define NP_IMAGE_PICTURE_PROCESS_H

#include "image/image_private.h"

typedef struct np_picture_request {
  const char *word;    /* word of picture_stream.h */
  const char *path;    /* path of the picture */
  const char *program; /* program in place of nephos_pictures, for tests; NULL: nephos_pictures */
} np_picture_request;

/* Passes a file to the program and reads its answer, whose every number is checked. `out_info` and `monitor` may be
 * NULL. */
neph_result np_picture_read(neph_context *context, const np_picture_request *request, np_monitor *monitor,
                            np_image_exr_info *out_info, neph_image **out_image);

#endif
