/* SPDX-License-Identifier: Apache-2.0 */
/* Writing OpenEXR: one part of scan lines, ZIP, or the format of a np_exr_format. */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/parallel.h"
#include "core/text.h"
#include "image/image_exr_write.h"

enum { ZIP_LEVEL = 4, SHORT_NAME_MAX = 31 };

/* ---- Errors ---- */

static void ignore_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)exr, (void)code, (void)message;
}

static neph_result fail_write(np_exr_file *file, exr_result_t code) {
  int error = atomic_load(&file->stream_error);
  if (error) return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: %s", file->path, strerror(error));
  if (code == EXR_ERR_OUT_OF_MEMORY)
    return np_fail(file->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: no memory to encode it", file->path);
  return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: OpenEXR: %s", file->path,
                 exr_get_default_error_message(code));
}

/* ---- Writing the header ---- */

static exr_pixel_type_t choose_pixel_type(const np_image_channel *channel, neph_pixel_type wanted) {
  return wanted == NEPH_PIXEL_FLOAT || np_image_is_float_channel(channel->name) ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF;
}

static exr_attr_box2i_t make_box(const int min[2], const int max[2]) {
  exr_attr_box2i_t box;
  box.min.x = min[0], box.min.y = min[1], box.max.x = max[0], box.max.y = max[1];
  return box;
}

static exr_result_t set_required(exr_context_t exr, const neph_image *image, exr_compression_t compression) {
  const np_image_header *header = &image->header;
  const int zero[2] = {0, 0}, last[2] = {(int)image->width - 1, (int)image->height - 1};
  exr_attr_box2i_t data = make_box(zero, last), display = data;
  if (header->has_window) {
    data = make_box(header->data_min, header->data_max);
    display = make_box(header->display_min, header->display_max);
  }
  exr_attr_v2f_t centre;
  centre.x = centre.y = 0.0f;
  exr_result_t code = exr_initialize_required_attr(exr, 0, &display, &data, 1.0f, &centre, 1.0f,
                                                   EXR_LINEORDER_INCREASING_Y, compression);
  return code ? code : exr_set_zip_compression_level(exr, 0, ZIP_LEVEL);
}

/* Whether names are so long that a flag is needed, which old readers refuse. */
static bool has_long_names(const neph_image *image) {
  for (unsigned c = 0; c < image->channel_count; c++)
    if (strlen(image->channels[c].name) > SHORT_NAME_MAX) return true;
  for (unsigned a = 0; a < image->attribute_count; a++)
    if (strlen(image->attributes[a].name) > SHORT_NAME_MAX) return true;
  return false;
}

static exr_result_t set_camera(exr_context_t exr, const np_image_header *header) {
  exr_attr_m44f_t camera, ndc;
  memcpy(&camera, header->world_to_camera, sizeof camera);
  memcpy(&ndc, header->world_to_ndc, sizeof ndc);
  exr_result_t code = exr_attr_set_m44f(exr, 0, "worldToCamera", &camera);
  return code || !header->has_ndc ? code : exr_attr_set_m44f(exr, 0, "worldToNDC", &ndc);
}

static exr_result_t set_attribute(exr_context_t exr, const np_image_attribute *attribute) {
  if (!strcmp(attribute->name, "software")) return EXR_ERR_SUCCESS;
  switch (attribute->type) {
  case NP_IMAGE_INTEGER:
    return exr_attr_set_int(exr, 0, attribute->name, (int32_t)attribute->number);
  case NP_IMAGE_REAL:
    return exr_attr_set_float(exr, 0, attribute->name, (float)attribute->number);
  case NP_IMAGE_TEXT:
    break;
  }
  return exr_attr_set_string(exr, 0, attribute->name, attribute->value);
}

static exr_result_t set_optional(exr_context_t exr, const neph_image *image) {
  char software[64];
  np_print(software, sizeof software, "nephos %s", neph_version_get_text());
  exr_result_t code = exr_attr_set_string(exr, 0, "software", software);
  if (!code && image->header.has_camera) code = set_camera(exr, &image->header);
  if (!code && image->header.is_latlong) code = exr_attr_set_envmap(exr, 0, "envmap", EXR_ENVMAP_LATLONG);
  if (!code && image->header.has_chromaticities) {
    exr_attr_chromaticities_t chromaticities;
    memcpy(&chromaticities, image->header.chromaticities, sizeof chromaticities);
    code = exr_attr_set_chromaticities(exr, 0, "chromaticities", &chromaticities);
  }
  for (unsigned a = 0; !code && a < image->attribute_count; a++) code = set_attribute(exr, &image->attributes[a]);
  return code;
}

static exr_result_t write_header(exr_context_t exr, const np_exr_writer *writer) {
  const neph_image *image = writer->image;
  const np_exr_format *format = writer->format;
  int part;
  exr_result_t code = exr_set_longname_support(exr, has_long_names(image));
  if (!code) code = exr_add_part(exr, NULL, format->storage, &part);
  if (!code) code = set_required(exr, image, format->compression);
  if (!code) code = format->add_channels(exr, image, writer->pixel_type);
  if (!code) code = set_optional(exr, image);
  return code ? code : exr_write_header(exr);
}

/* ---- Flat pixels ---- */

static exr_result_t add_channels(exr_context_t exr, const neph_image *image, neph_pixel_type pixel_type) {
  exr_result_t code = EXR_ERR_SUCCESS;
  for (unsigned c = 0; !code && c < image->channel_count; c++)
    code = exr_add_channel(exr, 0, image->channels[c].name, choose_pixel_type(&image->channels[c], pixel_type),
                           EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
  return code;
}

/* Points the encoder to the values. Channels are sorted by name in the file, not in the image. */
static void point_to_values(const neph_image *image, size_t first, exr_encode_pipeline_t *pipeline) {
  for (int c = 0; c < pipeline->channel_count; c++) {
    exr_coding_channel_info_t *channel = &pipeline->channels[c];
    np_exr_lay_out_channel(image, channel);
    channel->encode_from_ptr = (const uint8_t *)(neph_image_get_values(image, channel->channel_name) + first);
  }
}

/* Compresses a chunk; its bytes stay in the pipeline, which the caller destroys in any case. */
static exr_result_t run_pipeline(const np_exr_writer *writer, int line, exr_encode_pipeline_t *pipeline) {
  exr_context_t exr = writer->file.exr;
  exr_chunk_info_t info;
  exr_result_t code = exr_write_scanline_chunk_info(exr, 0, np_image_get_data_min(writer->image, 1) + line, &info);
  if (!code) code = exr_encoding_initialize(exr, 0, &info, pipeline);
  if (code) return code;
  point_to_values(writer->image, (size_t)line * writer->image->width, pipeline);
  code = exr_encoding_choose_default_routines(exr, 0, pipeline);
  pipeline->yield_until_ready_fn = NULL;
  pipeline->write_fn = NULL;
  return code ? code : exr_encoding_run(exr, 0, pipeline);
}

/* Readers take a chunk that is as long as its pixels as uncompressed, so that compression without gain is dropped.
 * OpenEXRCore drops it only where it lengthens. */
neph_result np_exr_copy_chunk(neph_context *context, const exr_encode_pipeline_t *pipeline, np_exr_chunk *out_chunk) {
  const bool is_raw = pipeline->compressed_bytes >= pipeline->packed_bytes;
  const size_t size = is_raw ? pipeline->packed_bytes : pipeline->compressed_bytes;
  out_chunk->bytes = np_alloc(context, size, 1);
  if (!out_chunk->bytes) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(out_chunk->bytes, is_raw ? pipeline->packed_buffer : pipeline->compressed_buffer, size);
  out_chunk->size = size;
  out_chunk->unpacked_size = pipeline->packed_bytes;
  return NEPH_OK;
}

static neph_result encode_chunk(np_exr_writer *writer, int index) {
  exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
  exr_result_t code = run_pipeline(writer, index * writer->lines_per_chunk, &pipeline);
  neph_result result = code ? np_exr_remember_failure(&writer->file, code)
                            : np_exr_copy_chunk(writer->file.context, &pipeline, &writer->chunks[index]);
  exr_encoding_destroy(writer->file.exr, &pipeline);
  return result;
}

static exr_result_t write_chunk(np_exr_writer *writer, int line, const np_exr_chunk *chunk) {
  return exr_write_scanline_chunk(writer->file.exr, 0, line, chunk->bytes, chunk->size);
}

static const np_exr_format flat = {EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP, add_channels, encode_chunk, write_chunk};

/* ---- Writing the pixels ---- */

static neph_result encode_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  np_exr_writer *writer = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; !result && i < end; i++) result = writer->format->encode_chunk(writer, (int)i);
  return result;
}

static neph_result write_pixels(np_exr_writer *writer) {
  np_exr_file *file = &writer->file;
  exr_result_t code = exr_get_scanlines_per_chunk(file->exr, 0, &writer->lines_per_chunk);
  if (!code) code = exr_get_chunk_count(file->exr, 0, &writer->chunk_count);
  if (code) return fail_write(file, code);
  writer->chunks = np_alloc(file->context, (size_t)writer->chunk_count, sizeof *writer->chunks);
  if (!writer->chunks) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(file->context, NULL, (size_t)writer->chunk_count, 1, encode_chunks, writer);
  if (result) return atomic_load(&file->worker_error) ? fail_write(file, atomic_load(&file->worker_error)) : result;
  for (int i = 0; !code && i < writer->chunk_count; i++)
    code = writer->format->write_chunk(writer, np_image_get_data_min(writer->image, 1) + i * writer->lines_per_chunk,
                                       &writer->chunks[i]);
  return code ? fail_write(file, code) : NEPH_OK;
}

static void free_chunks(np_exr_writer *writer) {
  for (int i = 0; writer->chunks && i < writer->chunk_count; i++) {
    np_alloc_free(writer->file.context, writer->chunks[i].bytes);
    np_alloc_free(writer->file.context, writer->chunks[i].counts);
  }
  np_alloc_free(writer->file.context, writer->chunks);
}

/* Finishes the file, which writes the table of chunks. */
static neph_result finish_file(np_exr_file *file) {
  exr_result_t code = exr_finish(&file->exr);
  if (code || atomic_load(&file->stream_error)) return fail_write(file, code);
  int descriptor = file->descriptor;
  file->descriptor = -1;
  if (!close(descriptor)) return NEPH_OK;
  atomic_store(&file->stream_error, errno);
  return fail_write(file, EXR_ERR_WRITE_IO);
}

static neph_result write_file(np_exr_writer *writer, const char *temporary) {
  np_exr_file *file = &writer->file;
  file->descriptor = open(temporary, O_WRONLY | O_CLOEXEC);
  if (file->descriptor < 0) {
    atomic_store(&file->stream_error, errno);
    return fail_write(file, EXR_ERR_FILE_ACCESS);
  }
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = ignore_complaint;
  initializer.user_data = file;
  initializer.write_fn = np_exr_write;
  exr_result_t code = exr_start_write(&file->exr, temporary, EXR_WRITE_FILE_DIRECTLY, &initializer);
  if (!code) code = write_header(file->exr, writer);
  neph_result result = code ? fail_write(file, code) : write_pixels(writer);
  free_chunks(writer);
  if (!result) result = finish_file(file);
  np_exr_close(file);
  return result;
}

neph_result np_exr_save(const neph_image *image, const char *path, neph_pixel_type pixel_type,
                        const np_exr_format *format) {
  np_file_write write;
  neph_result result = np_file_write_begin(image->context, path, &write);
  if (result) return result;
  np_exr_writer writer = {.file = {.context = image->context, .path = path, .descriptor = -1},
                          .image = image,
                          .format = format,
                          .pixel_type = pixel_type};
  result = write_file(&writer, write.temporary);
  if (!result) return np_file_write_commit(&write);
  np_file_write_abandon(&write);
  return result;
}

neph_result neph_image_save_exr(const neph_image *image, const char *path, neph_pixel_type pixel_type) {
  if (NP_LACKS(NP_CONTEXT_OF(image), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_exr_save(image, path, np_image_choose_pixel_type(image, path, pixel_type), &flat);
}
