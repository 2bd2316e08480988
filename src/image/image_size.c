/* SPDX-License-Identifier: Apache-2.0 */
/* The size and the kind of a picture, from its header alone. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "core/file.h"
#include "image/image_private.h"

/* Signature, then the chunk IHDR, which begins with width and height in big-endian order, bits of a sample and kind of
 * colour (ISO/IEC 15948, 5.2, 11.2.2). */
enum { PNG_HEAD = 26, PNG_TYPE_AT = 12, PNG_SIZE_AT = 16, PNG_BITS_AT = 24, PNG_COLOR_AT = 25 };

static unsigned read_big_endian(const unsigned char *bytes) {
  return (unsigned)bytes[0] << 24 | (unsigned)bytes[1] << 16 | (unsigned)bytes[2] << 8 | bytes[3];
}

static neph_result read_png_head(neph_context *context, const char *path, unsigned char out_head[PNG_HEAD]) {
  static const unsigned char signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const char *reason;
  const neph_result result = np_file_probe(path, &reason);
  if (result) return np_fail(context, result, "%s: cannot be read: %s", path, reason);
  FILE *file = np_file_open_stream(path);
  const size_t count = file ? fread(out_head, 1, PNG_HEAD, file) : 0;
  if (file) fclose(file);
  if (count == PNG_HEAD && !memcmp(out_head, signature, sizeof signature) && !memcmp(out_head + PNG_TYPE_AT, "IHDR", 4))
    return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: is not a PNG, or cut short", path);
}

static neph_result read_png_size(neph_context *context, const char *path, unsigned out_size[2]) {
  unsigned char head[PNG_HEAD];
  const neph_result result = read_png_head(context, path, head);
  for (int i = 0; i < 2 && !result; i++) out_size[i] = read_big_endian(head + PNG_SIZE_AT + 4 * (size_t)i);
  return result;
}

neph_result np_image_read_png_kind(neph_context *context, const char *path, unsigned *out_bits, bool *out_is_grey) {
  unsigned char head[PNG_HEAD];
  const neph_result result = read_png_head(context, path, head);
  if (result) return result;
  *out_bits = head[PNG_BITS_AT];
  *out_is_grey = head[PNG_COLOR_AT] == 0;
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
