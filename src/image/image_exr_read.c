/* SPDX-License-Identifier: Apache-2.0 */
/* Scan lines or tiles, whatever their compression. Chunks are decompressed on the context's threads. */
#include <openexr_decode.h>

#include "core/parallel.h"
#include "image/exr_header.h"

typedef struct exr_reader {
  np_exr_file file;
  neph_image *image;
  bool is_tiled;
  int chunk_width, chunk_height; /* of a whole chunk; the last ones may be smaller */
  int columns, rows;             /* of chunks */
  int first_line;                /* of the data window */
} exr_reader;

static neph_result check_kind(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  exr_storage_t storage;
  const exr_attr_chlist_t *channels;
  exr_result_t code = exr_get_storage(file->exr, 0, &storage);
  if (!code) code = exr_get_channels(file->exr, 0, &channels);
  if (code) return np_exr_fail_read(file, code);
  if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED, "%s: holds %s, must be scan lines or tiles", file->path,
                   np_exr_name_storage(storage));
  reader->is_tiled = storage == EXR_STORAGE_TILED;
  for (int c = 0; c < channels->num_channels; c++) {
    const exr_attr_chlist_entry_t *channel = &channels->entries[c];
    if (channel->x_sampling != 1 || channel->y_sampling != 1)
      return np_fail(file->context, NEPH_ERROR_UNSUPPORTED,
                     "%s: channel %s is sub-sampled %d × %d, every channel must have a value at each pixel", file->path,
                     channel->name.str, channel->x_sampling, channel->y_sampling);
  }
  return NEPH_OK;
}

static neph_result find_chunks(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  exr_attr_box2i_t window;
  int32_t tile_width = 0, tile_height = 0, lines = 0;
  exr_result_t code = exr_get_data_window(file->exr, 0, &window);
  if (!code && reader->is_tiled) code = exr_get_tile_sizes(file->exr, 0, 0, 0, &tile_width, &tile_height);
  if (!code && !reader->is_tiled) code = exr_get_scanlines_per_chunk(file->exr, 0, &lines);
  if (code) return np_exr_fail_read(file, code);
  neph_result result = np_exr_check_claims(file, &window, 1);
  if (result) return result;
  int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  reader->first_line = window.min.y;
  reader->chunk_width = reader->is_tiled ? tile_width : width;
  reader->chunk_height = reader->is_tiled ? tile_height : lines;
  if (reader->chunk_width < 1 || reader->chunk_height < 1) return np_exr_fail_read(file, EXR_ERR_FILE_BAD_HEADER);
  reader->columns = 1 + (width - 1) / reader->chunk_width;
  reader->rows = 1 + (height - 1) / reader->chunk_height;
  return NEPH_OK;
}

static exr_result_t find_chunk(const exr_reader *reader, int column, int row, exr_chunk_info_t *out_info) {
  exr_const_context_t exr = reader->file.exr;
  if (reader->is_tiled) return exr_read_tile_chunk_info(exr, 0, column, row, 0, 0, out_info);
  return exr_read_scanline_chunk_info(exr, 0, reader->first_line + row * reader->chunk_height, out_info);
}

/* The image was made from the file's channels, in their order. */
static exr_result_t point_into_image(const exr_reader *reader, int column, int row, exr_decode_pipeline_t *pipeline) {
  const neph_image *image = reader->image;
  int64_t x = (int64_t)column * reader->chunk_width, y = (int64_t)row * reader->chunk_height;
  if (pipeline->channel_count != (int)image->channel_count) return EXR_ERR_CORRUPT_CHUNK;
  for (int c = 0; c < pipeline->channel_count; c++) {
    exr_coding_channel_info_t *channel = &pipeline->channels[c];
    if (x + channel->width > image->width || y + channel->height > image->height) return EXR_ERR_CORRUPT_CHUNK;
    channel->user_bytes_per_element = sizeof(float);
    channel->user_data_type = EXR_PIXEL_FLOAT;
    channel->user_pixel_stride = sizeof(float);
    channel->user_line_stride = (int32_t)(image->width * sizeof(float));
    channel->decode_to_ptr = (uint8_t *)(image->channels[c].values + y * image->width + x);
  }
  return EXR_ERR_SUCCESS;
}

static exr_result_t decode_chunk(const exr_reader *reader, int column, int row) {
  exr_const_context_t exr = reader->file.exr;
  exr_chunk_info_t info;
  exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
  exr_result_t code = find_chunk(reader, column, row, &info);
  if (!code) code = exr_decoding_initialize(exr, 0, &info, &pipeline);
  if (code) return code;
  code = point_into_image(reader, column, row, &pipeline);
  if (!code) code = exr_decoding_choose_default_routines(exr, 0, &pipeline);
  if (!code) code = exr_decoding_run(exr, 0, &pipeline);
  exr_decoding_destroy(exr, &pipeline);
  return code;
}

static neph_result decode_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  exr_reader *reader = user;
  for (size_t i = begin; i < end; i++) {
    exr_result_t code = decode_chunk(reader, (int)i % reader->columns, (int)i / reader->columns);
    if (code) return np_exr_remember_worker_error(&reader->file, code);
  }
  return NEPH_OK;
}

static neph_result read_pixels(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  size_t count = (size_t)reader->columns * (size_t)reader->rows;
  neph_result result = np_parallel_for(file->context, NULL, count, 1, decode_chunks, reader);
  return result && atomic_load(&file->worker_error) ? np_exr_fail_read(file, atomic_load(&file->worker_error)) : result;
}

static neph_result read_file(exr_reader *reader) {
  exr_chunk_info_t first;
  neph_result result = np_exr_file_open_read(&reader->file);
  if (!result) result = check_kind(reader);
  if (!result) result = find_chunks(reader);
  if (result) return result;
  /* Makes the library check its table of chunks against the size of the file before the picture is allocated. */
  exr_result_t code = find_chunk(reader, 0, 0, &first);
  if (code) return np_exr_fail_read(&reader->file, code);
  result = np_exr_read_header(&reader->file, true, &reader->image);
  return result ? result : read_pixels(reader);
}

neph_result neph_image_load_exr(neph_context *context, const char *path, neph_image **out_image) {
  *out_image = NULL;
  exr_reader reader = {.file = {.context = context, .path = path, .descriptor = -1}};
  neph_result result = read_file(&reader);
  np_exr_file_close(&reader.file);
  if (!result)
    *out_image = reader.image;
  else
    neph_image_destroy(reader.image);
  return result;
}
