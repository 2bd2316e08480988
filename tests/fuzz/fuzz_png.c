/* SPDX-License-Identifier: Apache-2.0 */
/* A PNG picture. */
#include "fuzz_support.h"

#include <nephos/image.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  neph_image *image;
  fuzz_expect(neph_image_load_png(context, fuzz_write_file("picture.png", data, size), &image));
  neph_image_destroy(image);
  return 0;
}
