/* SPDX-License-Identifier: Apache-2.0 */
/* A PNG picture, by the decoder itself, and the texts of a preview. */
#include "fuzz_support.h"

#include <fcntl.h>

#include "core/alloc.h"
#include "image/picture_decoder.h"
#include "image/preview.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file("picture.png", data, size);
  neph_image *image;
  char *text;
  fuzz_expect(np_image_decode_png(context, open(path, O_RDONLY | O_CLOEXEC), path, &image));
  neph_image_destroy(image);
  fuzz_expect(np_preview_describe_file(context, path, NEPH_TEXT_JSON, &text));
  np_alloc_free(context, text);
  return 0;
}
