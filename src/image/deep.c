/* SPDX-License-Identifier: Apache-2.0 */
#include "image/deep.h"

#include <string.h>

#include "core/alloc.h"

neph_result np_image_add_deep(neph_image *image) {
  image->deep = np_alloc(image->context, (size_t)image->width * image->height, sizeof *image->deep);
  return image->deep ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_image_set_deep(neph_image *image, size_t pixel, const np_deep_sample *samples, unsigned count) {
  np_deep_pixel *p = &image->deep[pixel];
  np_alloc_free(image->context, p->samples);
  *p = (np_deep_pixel){.count = 0};
  if (count == 0) return NEPH_OK;
  p->samples = np_alloc(image->context, count, sizeof *samples);
  if (!p->samples) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(p->samples, samples, count * sizeof *samples);
  p->count = count;
  return NEPH_OK;
}

void np_image_clear_deep(neph_image *image) {
  const size_t count = image->deep ? (size_t)image->width * image->height : 0;
  for (size_t i = 0; i < count; i++) np_alloc_free(image->context, image->deep[i].samples);
  np_alloc_free(image->context, image->deep);
  image->deep = NULL;
}

bool neph_image_has_deep(const neph_image *image) { return image && image->deep; }
