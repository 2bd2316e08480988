/* SPDX-License-Identifier: Apache-2.0 */
/* Decoders of pictures from open files, in the calling process, which a crafted file may take over. They run in the
 * program nephos_pictures, and in fuzzers. */
#ifndef NP_IMAGE_PICTURE_DECODER_H
#define NP_IMAGE_PICTURE_DECODER_H

#include "image/image_private.h"

/* Decode a picture. Each closes the file in any case; `path` is for messages. */
neph_result np_image_decode_exr(neph_context *context, int file, const char *path, neph_image **out_image);
neph_result np_image_decode_exr_header(neph_context *context, int file, const char *path, np_image_exr_info *out_info,
                                       neph_image **out_image);
neph_result np_image_decode_png(neph_context *context, int file, const char *path, neph_image **out_image);

#endif
