/* SPDX-License-Identifier: Apache-2.0 */
/* An OpenEXR picture, by the decoder itself: its header, and whole. */
#include "fuzz_support.h"

#include <fcntl.h>

#include "image/picture_decoder.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("picture.exr", data, size);
  np_image_exr_info info;
  neph_image *image;
  fuzz_expect(np_image_decode_exr_header(context, open(path, O_RDONLY | O_CLOEXEC), path, &info, &image));
  neph_image_destroy(image);
  fuzz_expect(np_image_decode_exr(context, open(path, O_RDONLY | O_CLOEXEC), path, &image));
  neph_image_destroy(image);
  return 0;
}
