/* SPDX-License-Identifier: Apache-2.0 */
/* An OpenEXR picture: described, and read whole. */
#include "fuzz_support.h"

#include <nephos/image.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("picture.exr", data, size);
  char *text;
  neph_image *image;
  fuzz_expect(neph_image_describe_file(context, path, NEPH_TEXT_JSON, &text));
  neph_text_destroy(context, text);
  fuzz_expect(neph_image_load_exr(context, path, &image));
  neph_image_destroy(image);
  return 0;
}
