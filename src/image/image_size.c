/* SPDX-License-Identifier: Apache-2.0 */
/* The size of a picture, from its header alone. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "image/image_private.h"

/* Signature, then the chunk IHDR, which begins with width and height in big-endian order (ISO/IEC 15948, 5.2, 11.2.2).
 */
enum { PNG_HEAD = 24, PNG_TYPE_AT = 12, PNG_SIZE_AT = 16 };

static unsigned read_big_endian(const unsigned char *bytes) {
  return (unsigned)bytes[0] << 24 | (unsigned)bytes[1] << 16 | (unsigned)bytes[2] << 8 | bytes[3];
}

static neph_result read_png_size(neph_context *context, const char *path, unsigned out_size[2]) {
  static const unsigned char signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  unsigned char head[PNG_HEAD] = {0};
  FILE *file = fopen(path, "rb");
  const size_t count = file ? fread(head, 1, sizeof head, file) : 0;
  if (file) fclose(file);
  if (count < sizeof head || memcmp(head, signature, sizeof signature) || memcmp(head + PNG_TYPE_AT, "IHDR", 4))
    return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: is not a PNG, or cut short", path);
  for (int i = 0; i < 2; i++) out_size[i] = read_big_endian(head + PNG_SIZE_AT + 4 * (size_t)i);
  return NEPH_OK;
}

static neph_result read_exr_size(neph_context *context, const char *path, unsigned out_size[2]) {
  np_image_exr_info info;
  neph_image *image = NULL;
  neph_result result = np_image_read_exr_header(context, path, &info, &image);
  if (result) return result;
  out_size[0] = image->width;
  out_size[1] = image->height;
  neph_image_destroy(image);
  return NEPH_OK;
}

neph_result np_image_read_size(neph_context *context, const char *path, unsigned out_size[2]) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *ending = strrchr(name, '.');
  if (ending && !strcasecmp(ending, ".png")) return read_png_size(context, path, out_size);
  if (ending && !strcasecmp(ending, ".exr")) return read_exr_size(context, path, out_size);
  return np_fail(context, NEPH_ERROR_UNSUPPORTED, "%s: pictures are read from .exr and .png, not from \"%s\"", path,
                 ending ? ending : name);
}
