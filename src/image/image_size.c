/* SPDX-License-Identifier: Apache-2.0 */
/* The size, the channels and the kind of a picture, from its header alone. */
#include <stdio.h>
#include <string.h>

#include "core/file.h"
#include "image/image_private.h"

/* Offsets in a PNG: signature, then the chunk IHDR, which begins with width and height in big-endian order, bits of a
 * sample and kind of colour (ISO/IEC 15948, 5.2, 11.2.2). */
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

const char *np_image_name_png_samples(unsigned bits, bool is_palette) {
  static const char *const names[] = {[1] = "1-bit", [2] = "2-bit", [4] = "4-bit", [8] = "8-bit", [16] = "16-bit"};
  return is_palette ? "palette" : bits < sizeof names / sizeof *names ? names[bits] : NULL;
}

/* Reads a PNG's header. Channels are those of a load, except for a transparent colour, which comes after the header. */
static neph_result read_png_header(neph_context *context, const char *path, neph_image **out_image) {
  static const struct {
    unsigned channel_count;
    const char *names[4];
  } kinds[] = {[0] = {1, {"Y"}},
               [2] = {3, {"R", "G", "B"}},
               [3] = {3, {"R", "G", "B"}},
               [4] = {2, {"Y", "A"}},
               [6] = {4, {"R", "G", "B", "A"}}};
  unsigned char head[PNG_HEAD];
  neph_result result = read_png_head(context, path, head);
  if (result) return result;
  const unsigned width = read_big_endian(head + PNG_SIZE_AT), height = read_big_endian(head + PNG_SIZE_AT + 4);
  const unsigned color = head[PNG_COLOR_AT],
                 count = color < sizeof kinds / sizeof *kinds ? kinds[color].channel_count : 0;
  const char *stored = np_image_name_png_samples(head[PNG_BITS_AT], color == 3);
  if (!count || !stored)
    return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: is a damaged PNG: kind of colour %u, %u bits", path, color,
                   head[PNG_BITS_AT]);
  result = np_image_check_claims(context, path, width, height, (int)count);
  if (!result) result = np_image_create(context, width, height, count, kinds[color].names, false, out_image);
  for (unsigned c = 0; !result && c < count; c++) (*out_image)->channels[c].stored = stored;
  return result;
}

static neph_result read_exr_header(neph_context *context, const char *path, neph_image **out_image) {
  np_image_exr_info info;
  return np_image_read_exr_header(context, path, &info, out_image);
}

static neph_result read_exr_size(neph_context *context, const char *path, unsigned out_size[2]) {
  neph_image *image = NULL;
  neph_result result = read_exr_header(context, path, &image);
  if (result) return result;
  out_size[0] = image->width;
  out_size[1] = image->height;
  neph_image_destroy(image);
  return NEPH_OK;
}

static neph_result fail_ending(neph_context *context, const char *path) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *ending = strrchr(name, '.');
  return np_fail(context, NEPH_ERROR_UNSUPPORTED, "%s: pictures are read from .exr and .png, not from \"%s\"", path,
                 ending ? ending : name);
}

neph_result np_image_read_header(neph_context *context, const char *path, neph_image **out_image) {
  *out_image = NULL;
  if (np_file_has_ending(path, ".png")) return read_png_header(context, path, out_image);
  if (np_file_has_ending(path, ".exr")) return read_exr_header(context, path, out_image);
  return fail_ending(context, path);
}

neph_result np_image_read_size(neph_context *context, const char *path, unsigned out_size[2]) {
  if (np_file_has_ending(path, ".png")) return read_png_size(context, path, out_size);
  if (np_file_has_ending(path, ".exr")) return read_exr_size(context, path, out_size);
  return fail_ending(context, path);
}
