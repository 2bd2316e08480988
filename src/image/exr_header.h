/* SPDX-License-Identifier: Apache-2.0 */
/* What stands in front of an OpenEXR file's pixels. */
#ifndef NP_IMAGE_EXR_HEADER_H
#define NP_IMAGE_EXR_HEADER_H

#include "image/exr_file.h"
#include "image/image_private.h"

/* Whether a picture of this window may be read; asked before anything is allocated for what a header claims. */
neph_result np_exr_check_claims(np_exr_file *file, const exr_attr_box2i_t *window, int channel_count);

/* An image with the file's channels, in their order, and its attributes; with room for pixels if `has_values`. */
neph_result np_exr_read_header(np_exr_file *file, bool has_values, neph_image **out_image);
const char *np_exr_name_storage(exr_storage_t storage);

#endif
