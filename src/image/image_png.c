/* SPDX-License-Identifier: Apache-2.0 */
/* PNG through libpng: previews out, maps and height fields in. Reading runs in the program nephos_pictures alone
 * (picture_process.h). */
#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/parallel.h"
#include "core/text.h"
#include "image/picture_decoder.h"
#include "image/png_rows.h"
#include "image/preview.h"

/* ---- Writing ---- */

static neph_result fail_write(neph_context *context, const char *path, const char *why) {
  return np_fail(context, NEPH_ERROR_IO, "%s: cannot be written: %s", path, why);
}

typedef struct png_picture {
  const neph_image *image;
  const neph_preview_desc *desc;
  uint16_t *rgb;
  double exposure_ev; /* stops from values to display light */
} png_picture;

/* Packs a row as the file has it: 16 bits with the high byte first. */
static void pack_row(const void *user, size_t row, uint8_t *out) {
  const png_picture *picture = user;
  const size_t count = 3 * (size_t)picture->image->width;
  const uint16_t *rgb = picture->rgb + row * count;
  for (size_t i = 0; i < count; i++)
    if (picture->desc->bits == 8)
      out[i] = (uint8_t)rgb[i];
    else
      out[2 * i] = (uint8_t)(rgb[i] >> 8), out[2 * i + 1] = (uint8_t)rgb[i];
}

/* Writes the texts that mark the file as a preview. */
static void put_texts(png_structp png, png_infop info, const png_picture *picture) {
  char exposure[32];
  np_print(exposure, sizeof exposure, "%+.2f", picture->exposure_ev);
  const struct {
    const char *key, *value;
  } rows[] = {{NP_PREVIEW_VIEW, np_preview_name_view(picture->desc->view)},
              {NP_PREVIEW_EXPOSURE, exposure},
              {NP_PREVIEW_FRAME, neph_image_get_attribute(picture->image, "nephos:frame")}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    png_text text = {.compression = PNG_TEXT_COMPRESSION_NONE,
                     .key = (png_charp)(uintptr_t)rows[i].key,
                     .text = (png_charp)(uintptr_t)rows[i].value};
    if (rows[i].value) png_set_text(png, info, &text, 1);
  }
}

static void write_header(png_structp png, png_infop info, const png_picture *picture) {
  const neph_image *image = picture->image;
  png_set_IHDR(png, info, image->width, image->height, (int)picture->desc->bits, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (picture->desc->view == NEPH_VIEW_RAW)
    png_set_gAMA(png, info, 1.0);
  else if (picture->desc->view != NEPH_VIEW_OCIO) /* whose encoding the configuration alone knows */
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  put_texts(png, info, picture);
  png_write_info(png, info);
}

/* Error function of libpng: stores the message and jumps. */
static void store_message(png_structp png, png_const_charp message) {
  np_print_short(png_get_error_ptr(png), 128, message);
  png_longjmp(png, 1);
}

static void ignore_warning(png_structp png, png_const_charp message) { (void)png, (void)message; }

/* The picture's rows as they stand in the file. */
typedef struct png_body {
  np_png_strip *strips;
  size_t count;
} png_body;

static neph_result compress_body(const png_picture *picture, png_body *out) {
  const unsigned pixel_bytes = picture->desc->bits == 8 ? 3 : 6;
  const np_png_rows rows = {.height = picture->image->height,
                            .row_bytes = (size_t)picture->image->width * pixel_bytes,
                            .pixel_bytes = pixel_bytes,
                            .pack = pack_row,
                            .user = picture};
  return np_png_rows_compress(picture->image->context, &rows, &out->strips, &out->count);
}

static bool write_chunks(png_structp png, png_infop info, const png_picture *picture, const png_body *body,
                         FILE *file) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_init_io(png, file);
  write_header(png, info, picture);
  for (size_t i = 0; i < body->count; i++)
    png_write_chunk(png, (png_const_bytep) "IDAT", body->strips[i].bytes, body->strips[i].size);
  png_write_chunk(png, (png_const_bytep) "IEND", NULL, 0);
  return fflush(file) == 0;
}

/* Writes the picture. False: failed. */
static bool write_stream(const png_picture *picture, const png_body *body, FILE *file, char message[128]) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, store_message, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : NULL;
  const bool is_written = info && write_chunks(png, info, picture, body, file);
  png_destroy_write_struct(&png, &info);
  return is_written;
}

static neph_result write_rgb(const png_picture *picture, const char *path, const char *temporary) {
  neph_context *context = picture->image->context;
  char message[128] = "out of memory";
  png_body body;
  const neph_result result = compress_body(picture, &body);
  if (result) return result;
  FILE *file = fopen(temporary, "wb");
  errno = file ? 0 : errno;
  bool is_written = file && write_stream(picture, &body, file, message);
  int error = errno;
  np_png_strips_free(context, body.strips, body.count);
  if (file && fclose(file) != 0 && is_written) {
    is_written = false;
    error = errno;
  }
  return is_written ? NEPH_OK : fail_write(context, path, error ? strerror(error) : message);
}

static neph_result write_file(const png_picture *picture, const char *path) {
  np_file_write write;
  neph_result result = np_file_write_begin(picture->image->context, path, &write);
  if (result) return result;
  result = write_rgb(picture, path, write.temporary);
  if (!result) return np_file_write_commit(&write);
  np_file_write_abandon(&write);
  return result;
}

neph_result neph_image_save_png(const neph_image *image, const char *path, const neph_preview_desc *desc) {
  if (NP_LACKS(NP_CONTEXT_OF(image), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  const neph_preview_desc defaults = NEPH_PREVIEW_DESC_DEFAULT;
  neph_preview_desc wanted;
  neph_result result = np_desc_read(image->context, "neph_preview_desc", &defaults, sizeof defaults, desc, &wanted);
  if (result) return result;
  png_picture picture = {image, &wanted, np_alloc(image->context, (size_t)image->width * image->height, 6), 0.0};
  if (!picture.rgb) return NEPH_ERROR_OUT_OF_MEMORY;
  result = np_preview_render(image, &wanted, picture.rgb, &picture.exposure_ev);
  if (!result) result = write_file(&picture, path);
  np_alloc_free(image->context, picture.rgb);
  return result;
}

static neph_result encode(const png_picture *picture, void **out_bytes, size_t *out_size) {
  neph_context *context = picture->image->context;
  char message[128] = "out of memory", *stream_bytes = NULL;
  size_t size = 0;
  png_body body;
  const neph_result result = compress_body(picture, &body);
  if (result) return result;
  FILE *stream = open_memstream(&stream_bytes, &size);
  bool is_written = stream && write_stream(picture, &body, stream, message);
  if (stream && fclose(stream)) is_written = false;
  void *bytes = is_written ? np_alloc(context, size, 1) : NULL;
  if (bytes) *out_bytes = memcpy(bytes, stream_bytes, size);
  *out_size = size;
  free(stream_bytes);
  np_png_strips_free(context, body.strips, body.count);
  return bytes ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_image_encode_png(const neph_image *image, const neph_preview_desc *desc, void **out_bytes,
                                size_t *out_size) {
  *out_bytes = NULL;
  png_picture picture = {image, desc, np_alloc(image->context, (size_t)image->width * image->height, 6), 0.0};
  if (!picture.rgb) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_preview_render(image, desc, picture.rgb, &picture.exposure_ev);
  if (!result) result = encode(&picture, out_bytes, out_size);
  np_alloc_free(image->context, picture.rgb);
  return result;
}

/* ---- Reading ---- */

/* State of reading, outside of registers, so that it survives a jump out of libpng. */
typedef struct png_reader {
  neph_context *context;
  const char *path;
  const uint8_t *bytes;
  size_t size, next;
  png_structp png;
  png_infop info;
  const char *stored; /* kind of samples, as np_image_channel::stored */
  neph_image *image;
  uint8_t *pixels;
  png_bytep *rows;
  neph_result result; /* result already reported; NEPH_OK until then */
  char message[128];
} png_reader;

/* Leaves libpng by longjmp, as its own errors do. */
static void fail_reading(png_reader *reader, neph_result result) {
  reader->result = result;
  png_longjmp(reader->png, 1);
}

static void read_bytes(png_structp png, png_bytep out, size_t size) {
  png_reader *reader = png_get_io_ptr(png);
  if (size > reader->size - reader->next) png_error(png, "the file is cut short");
  memcpy(out, reader->bytes + reader->next, size);
  reader->next += size;
}

static void jump_out(png_structp png, png_const_charp message) {
  png_reader *reader = png_get_error_ptr(png);
  np_print_short(reader->message, sizeof reader->message, message);
  png_longjmp(png, 1);
}

/* Size of blocks that are always allowed: rows of the widest picture, and texts longer than their compressed form. */
static const png_alloc_size_t block_bytes_free = 8000000;

/* Allocation function of libpng, which continues without some of its blocks; reading fails in any case after a lack of
 * memory. libpng allocates a chunk's stated length: more than the file's size is refused. */
static png_voidp allocate(png_structp png, png_alloc_size_t size) {
  png_reader *reader = png_get_mem_ptr(png);
  if (size > block_bytes_free + reader->size) return NULL;
  void *block = np_alloc(reader->context, size, 1);
  if (!block) reader->result = NEPH_ERROR_OUT_OF_MEMORY;
  return block;
}

static void release(png_structp png, png_voidp block) {
  np_alloc_free(((png_reader *)png_get_mem_ptr(png))->context, block);
}

static void check_size(png_reader *reader, unsigned channel_count) {
  const neph_result result =
      np_image_check_claims(reader->context, reader->path, png_get_image_width(reader->png, reader->info),
                            png_get_image_height(reader->png, reader->info), (int)channel_count);
  if (result) fail_reading(reader, result);
}

/* Kind of samples in the file, before the transforms. */
static const char *name_samples(const png_reader *reader) {
  return np_image_name_png_samples(png_get_bit_depth(reader->png, reader->info),
                                   png_get_color_type(reader->png, reader->info) == PNG_COLOR_TYPE_PALETTE);
}

/* Sets transforms: palettes become colour, 1 to 4 bits become 8, a transparent colour becomes alpha; 16-bit samples get
 * the machine's byte order. */
static void set_transforms(png_structp png) {
  const uint16_t one = 1;
  png_set_expand(png);
  if (*(const uint8_t *)&one == 1) png_set_swap(png);
  png_set_interlace_handling(png);
}

static void create_image(png_reader *reader) {
  static const char *const names[4][4] = {{"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
  unsigned channel_count = png_get_channels(reader->png, reader->info);
  unsigned width = png_get_image_width(reader->png, reader->info);
  unsigned height = png_get_image_height(reader->png, reader->info);
  check_size(reader, channel_count);
  neph_result result =
      neph_image_create(reader->context, width, height, channel_count, names[channel_count - 1], &reader->image);
  if (result) fail_reading(reader, result);
  for (unsigned c = 0; c < channel_count; c++) reader->image->channels[c].stored = reader->stored;
  reader->pixels = np_alloc(reader->context, height, png_get_rowbytes(reader->png, reader->info));
  reader->rows = np_alloc(reader->context, height, sizeof *reader->rows);
  if (!reader->pixels || !reader->rows) fail_reading(reader, NEPH_ERROR_OUT_OF_MEMORY);
}

static float get_sample(const uint8_t *row, size_t index, unsigned bits) {
  uint16_t sample;
  if (bits == 8) return (float)row[index] / 255.0f;
  memcpy(&sample, row + 2 * index, sizeof sample);
  return (float)sample / 65535.0f;
}

static void copy_samples(png_reader *reader) {
  neph_image *image = reader->image;
  unsigned bits = png_get_bit_depth(reader->png, reader->info), channel_count = image->channel_count;
  for (size_t y = 0; y < image->height; y++)
    for (size_t x = 0; x < image->width; x++)
      for (unsigned c = 0; c < channel_count; c++)
        image->channels[c].values[y * image->width + x] = get_sample(reader->rows[y], x * channel_count + c, bits);
}

static void read_picture(png_reader *reader) {
  png_structp png = reader->png;
  png_set_read_fn(png, reader, read_bytes);
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* limits of the library apply instead */
  png_read_info(png, reader->info);
  check_size(reader, 1);
  reader->stored = name_samples(reader);
  set_transforms(png);
  png_read_update_info(png, reader->info);
  create_image(reader);
  size_t row_bytes = png_get_rowbytes(png, reader->info);
  for (size_t y = 0; y < reader->image->height; y++) reader->rows[y] = reader->pixels + y * row_bytes;
  png_read_image(png, reader->rows);
  png_read_end(png, NULL);
  copy_samples(reader);
}

static neph_result fail_read(png_reader *reader) {
  if (reader->result) return reader->result;
  return np_fail(reader->context, NEPH_ERROR_BAD_FILE, "%s: damaged, cut short or no PNG: %s", reader->path,
                 reader->message);
}

/* Runs libpng. This frame is the only target of its jumps; all state is in `reader`. */
static neph_result run_libpng(png_reader *reader) {
  reader->png =
      png_create_read_struct_2(PNG_LIBPNG_VER_STRING, reader, jump_out, ignore_warning, reader, allocate, release);
  if (!reader->png) return NEPH_ERROR_OUT_OF_MEMORY;
  if (setjmp(png_jmpbuf(reader->png))) return fail_read(reader);
  reader->info = png_create_info_struct(reader->png);
  if (!reader->info) return NEPH_ERROR_OUT_OF_MEMORY;
  read_picture(reader);
  return reader->result;
}

neph_result np_image_decode_png(neph_context *context, int descriptor, const char *path, neph_image **out_image) {
  void *bytes;
  png_reader reader = {.context = context, .path = path};
  *out_image = NULL;
  neph_result result = np_file_read_rest(context, path, descriptor, &bytes, &reader.size);
  if (result) return result;
  reader.bytes = bytes;
  result = run_libpng(&reader);
  png_destroy_read_struct(&reader.png, &reader.info, NULL);
  np_alloc_free(context, reader.pixels);
  np_alloc_free(context, reader.rows);
  np_alloc_free(context, bytes);
  if (!result)
    *out_image = reader.image;
  else
    neph_image_destroy(reader.image);
  return result;
}
