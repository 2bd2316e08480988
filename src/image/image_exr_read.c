/* SPDX-License-Identifier: Apache-2.0 */
/* Reading OpenEXR: scan lines and tiles of the first part. Chunks are decompressed on the context's threads. It runs in
 * the program nephos_pictures alone (picture_process.h). */
#include <string.h>
#include <unistd.h>

#include <openexr_decode.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/text.h"
#include "image/image_exr.h"
#include "image/picture_decoder.h"

/* ---- Errors ---- */

/* Stores the first complaint for the message. Only for reading: a context open for writing holds its lock during a
 * complaint, and the call for its user data would deadlock. */
static void store_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)code;
  void *user = NULL;
  if (!exr || exr_get_user_data(exr, &user) || !user) return;
  np_exr_file *file = user;
  if (!atomic_exchange(&file->has_complaint, true)) np_print_short(file->complaint, sizeof file->complaint, message);
}

/* Text of the first complaint without the file's name, with which OpenEXRCore begins. */
static const char *describe_complaint(const np_exr_file *file, exr_result_t code) {
  if (!file->complaint[0]) return exr_get_default_error_message(code);
  const char *name_end = strstr(file->complaint, "': ");
  return file->complaint[0] == '\'' && name_end ? name_end + 3 : file->complaint;
}

static neph_result fail_read(np_exr_file *file, exr_result_t code) {
  int error = atomic_load(&file->stream_error);
  if (error) return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be read: %s", file->path, strerror(error));
  if (code == EXR_ERR_OUT_OF_MEMORY)
    return np_fail(file->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: no memory to decode it", file->path);
  if (code == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED, "%s: OpenEXR cannot decode it here: %s", file->path,
                   describe_complaint(file, code));
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: damaged, cut short or no OpenEXR file: %s", file->path,
                 describe_complaint(file, code));
}

/* ---- Reading the header ---- */

static neph_result open_file(np_exr_file *file) {
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = store_complaint;
  initializer.user_data = file;
  initializer.read_fn = np_exr_read;
  initializer.size_fn = np_exr_get_size;
  initializer.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  exr_result_t code = exr_start_read(&file->exr, file->path, &initializer);
  return code ? fail_read(file, code) : NEPH_OK;
}

static neph_result check_claims(const np_exr_file *file, const exr_attr_box2i_t *window, int channel_count) {
  return np_image_check_claims(file->context, file->path, (int64_t)window->max.x - window->min.x + 1,
                               (int64_t)window->max.y - window->min.y + 1, channel_count);
}

static const char *name_pixel_type(exr_pixel_type_t type) {
  switch (type) {
  case EXR_PIXEL_UINT:
    return "uint";
  case EXR_PIXEL_HALF:
    return "half";
  case EXR_PIXEL_FLOAT:
    return "float";
  case EXR_PIXEL_LAST_TYPE:
    break;
  }
  return "unknown";
}

static neph_result create_image(np_exr_file *file, bool has_values, neph_image **out_image) {
  exr_attr_box2i_t window;
  const exr_attr_chlist_t *channels;
  exr_result_t code = exr_get_data_window(file->exr, 0, &window);
  if (!code) code = exr_get_channels(file->exr, 0, &channels);
  if (code) return fail_read(file, code);
  neph_result result = check_claims(file, &window, channels->num_channels);
  if (result) return result;
  const char **names = np_alloc(file->context, (size_t)channels->num_channels, sizeof *names);
  if (!names) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int c = 0; c < channels->num_channels; c++) names[c] = channels->entries[c].name.str;
  unsigned width = (unsigned)(window.max.x - window.min.x + 1), height = (unsigned)(window.max.y - window.min.y + 1);
  result =
      np_image_create(file->context, width, height, (unsigned)channels->num_channels, names, has_values, out_image);
  np_alloc_free(file->context, names);
  for (int c = 0; !result && c < channels->num_channels; c++)
    (*out_image)->channels[c].stored = name_pixel_type(channels->entries[c].pixel_type);
  return result;
}

static neph_result read_windows(np_exr_file *file, np_image_header *header) {
  exr_attr_box2i_t data, display;
  exr_result_t code = exr_get_data_window(file->exr, 0, &data);
  if (!code) code = exr_get_display_window(file->exr, 0, &display);
  if (code) return fail_read(file, code);
  header->has_window = memcmp(&data, &display, sizeof data) != 0 || data.min.x != 0 || data.min.y != 0;
  header->data_min[0] = data.min.x, header->data_min[1] = data.min.y;
  header->data_max[0] = data.max.x, header->data_max[1] = data.max.y;
  header->display_min[0] = display.min.x, header->display_min[1] = display.min.y;
  header->display_max[0] = display.max.x, header->display_max[1] = display.max.y;
  return NEPH_OK;
}

static void read_matrices(const np_exr_file *file, np_image_header *header) {
  exr_attr_m44f_t camera, ndc;
  exr_attr_chromaticities_t chromaticities;
  exr_envmap_t map;
  header->has_camera = !exr_attr_get_m44f(file->exr, 0, "worldToCamera", &camera);
  header->has_ndc = header->has_camera && !exr_attr_get_m44f(file->exr, 0, "worldToNDC", &ndc);
  if (header->has_camera) memcpy(header->world_to_camera, &camera, sizeof camera);
  if (header->has_ndc) memcpy(header->world_to_ndc, &ndc, sizeof ndc);
  header->is_latlong = !exr_attr_get_envmap(file->exr, 0, "envmap", &map) && map == EXR_ENVMAP_LATLONG;
  if (!exr_attr_get_chromaticities(file->exr, 0, "chromaticities", &chromaticities)) {
    memcpy(header->chromaticities, &chromaticities, sizeof chromaticities);
    header->has_chromaticities = true;
  }
}

static neph_result read_attribute(neph_image *image, const exr_attribute_t *attribute) {
  switch ((int)attribute->type) {
  case EXR_ATTR_INT:
    return np_image_set_integer(image, attribute->name, attribute->i);
  case EXR_ATTR_FLOAT:
    return np_image_set_real(image, attribute->name, (double)attribute->f);
  case EXR_ATTR_DOUBLE:
    return np_image_set_real(image, attribute->name, attribute->d);
  case EXR_ATTR_STRING:
    return neph_image_set_attribute(image, attribute->name, attribute->string->str);
  default:
    return NEPH_OK;
  }
}

/* Whether an attribute is required by OpenEXR; these are not copied from file to file. */
static bool is_structural(const char *name) {
  static const char *const names[] = {"name", "type", "version", "chunkCount", "pixelAspectRatio", "screenWindowWidth"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (!strcmp(names[i], name)) return true;
  return false;
}

static neph_result read_attributes(np_exr_file *file, neph_image *image) {
  int32_t count = 0;
  exr_result_t code = exr_get_attribute_count(file->exr, 0, &count);
  neph_result result = code ? fail_read(file, code) : NEPH_OK;
  for (int32_t i = 0; !result && i < count; i++) {
    const exr_attribute_t *attribute;
    code = exr_get_attribute_by_index(file->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute);
    if (code) return fail_read(file, code);
    if (!is_structural(attribute->name)) result = read_attribute(image, attribute);
  }
  return result;
}

static neph_result read_header(np_exr_file *file, bool has_values, neph_image **out_image) {
  neph_result result = create_image(file, has_values, out_image);
  if (result) return result;
  result = read_windows(file, &(*out_image)->header);
  read_matrices(file, &(*out_image)->header);
  if (!result) result = read_attributes(file, *out_image);
  if (!result) return NEPH_OK;
  neph_image_destroy(*out_image);
  *out_image = NULL;
  return result;
}

static const char *name_storage(exr_storage_t storage) {
  switch (storage) {
  case EXR_STORAGE_SCANLINE:
    return "scan lines";
  case EXR_STORAGE_TILED:
    return "tiles";
  case EXR_STORAGE_DEEP_SCANLINE:
    return "deep scan lines";
  case EXR_STORAGE_DEEP_TILED:
    return "deep tiles";
  case EXR_STORAGE_LAST_TYPE:
    break;
  }
  return "unknown";
}

static const char *name_compression(exr_compression_t compression) {
  static const char *const names[] = {"none", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"};
  return (unsigned)compression < sizeof names / sizeof *names ? names[compression] : "unknown";
}

static neph_result read_info(np_exr_file *file, np_image_exr_info *out_info) {
  exr_storage_t storage;
  exr_compression_t compression;
  exr_tile_level_mode_t level_mode;
  exr_tile_round_mode_t round_mode;
  *out_info = (np_image_exr_info){.part_count = 0};
  exr_result_t code = exr_get_count(file->exr, &out_info->part_count);
  if (!code) code = exr_get_storage(file->exr, 0, &storage);
  if (!code) code = exr_get_compression(file->exr, 0, &compression);
  if (!code && (storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED))
    code =
        exr_get_tile_descriptor(file->exr, 0, &out_info->tile_width, &out_info->tile_height, &level_mode, &round_mode);
  if (code) return fail_read(file, code);
  out_info->storage = name_storage(storage);
  out_info->compression = name_compression(compression);
  return NEPH_OK;
}

neph_result np_image_decode_exr_header(neph_context *context, int descriptor, const char *path,
                                       np_image_exr_info *out_info, neph_image **out_image) {
  *out_image = NULL;
  np_exr_file file = {.context = context, .path = path, .descriptor = descriptor};
  neph_result result = open_file(&file);
  if (!result) result = read_info(&file, out_info);
  if (!result) result = read_header(&file, false, out_image);
  np_exr_close(&file);
  return result;
}

/* ---- Reading the pixels ---- */

typedef struct exr_reader {
  np_exr_file file;
  neph_image *image;
  bool is_tiled;
  int chunk_width, chunk_height; /* size of a whole chunk; the last chunks may be smaller */
  int columns, rows;             /* numbers of chunks */
  int first_line;                /* first line of the data window */
} exr_reader;

static neph_result check_kind(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  exr_storage_t storage;
  const exr_attr_chlist_t *channels;
  exr_result_t code = exr_get_storage(file->exr, 0, &storage);
  if (!code) code = exr_get_channels(file->exr, 0, &channels);
  if (code) return fail_read(file, code);
  if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED, "%s: holds %s, must be scan lines or tiles", file->path,
                   name_storage(storage));
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

static neph_result count_chunks(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  exr_attr_box2i_t window;
  int32_t tile_width = 0, tile_height = 0, lines = 0;
  exr_result_t code = exr_get_data_window(file->exr, 0, &window);
  if (!code && reader->is_tiled) code = exr_get_tile_sizes(file->exr, 0, 0, 0, &tile_width, &tile_height);
  if (!code && !reader->is_tiled) code = exr_get_scanlines_per_chunk(file->exr, 0, &lines);
  if (code) return fail_read(file, code);
  neph_result result = check_claims(file, &window, 1);
  if (result) return result;
  int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  reader->first_line = window.min.y;
  reader->chunk_width = reader->is_tiled ? tile_width : width;
  reader->chunk_height = reader->is_tiled ? tile_height : lines;
  if (reader->chunk_width < 1 || reader->chunk_height < 1) return fail_read(file, EXR_ERR_FILE_BAD_HEADER);
  reader->columns = 1 + (width - 1) / reader->chunk_width;
  reader->rows = 1 + (height - 1) / reader->chunk_height;
  return NEPH_OK;
}

static exr_result_t read_chunk_info(const exr_reader *reader, int column, int row, exr_chunk_info_t *out_info) {
  exr_const_context_t exr = reader->file.exr;
  if (reader->is_tiled) return exr_read_tile_chunk_info(exr, 0, column, row, 0, 0, out_info);
  return exr_read_scanline_chunk_info(exr, 0, reader->first_line + row * reader->chunk_height, out_info);
}

/* Points the decoder into the image, whose channels have the order of the file's. */
static exr_result_t point_into_image(const exr_reader *reader, int column, int row, exr_decode_pipeline_t *pipeline) {
  const neph_image *image = reader->image;
  int64_t x = (int64_t)column * reader->chunk_width, y = (int64_t)row * reader->chunk_height;
  if (pipeline->channel_count != (int)image->channel_count) return EXR_ERR_CORRUPT_CHUNK;
  for (int c = 0; c < pipeline->channel_count; c++) {
    exr_coding_channel_info_t *channel = &pipeline->channels[c];
    if (x + channel->width > image->width || y + channel->height > image->height) return EXR_ERR_CORRUPT_CHUNK;
    np_exr_lay_out_channel(image, channel);
    channel->decode_to_ptr = (uint8_t *)(image->channels[c].values + y * image->width + x);
  }
  return EXR_ERR_SUCCESS;
}

/* Distinguishes a damaged chunk from a lack of memory: the decoders of PIZ, PXR24 and B44 report "no memory" also for a
 * chunk whose bytes end too soon or too late. Memory was sufficient if all buffers of the chunk exist; PIZ has a second
 * work buffer. */
static exr_result_t judge_failure(exr_result_t code, const exr_decode_pipeline_t *pipeline) {
  const bool has_buffers = pipeline->packed_buffer && pipeline->unpacked_buffer && pipeline->scratch_buffer_1 &&
                           (pipeline->chunk.compression != EXR_COMPRESSION_PIZ || pipeline->scratch_buffer_2);
  return code == EXR_ERR_OUT_OF_MEMORY && has_buffers ? EXR_ERR_CORRUPT_CHUNK : code;
}

static exr_result_t decode_chunk(const exr_reader *reader, int column, int row) {
  exr_const_context_t exr = reader->file.exr;
  exr_chunk_info_t info;
  exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
  exr_result_t code = read_chunk_info(reader, column, row, &info);
  if (!code) code = exr_decoding_initialize(exr, 0, &info, &pipeline);
  if (code) return code;
  code = point_into_image(reader, column, row, &pipeline);
  if (!code) code = exr_decoding_choose_default_routines(exr, 0, &pipeline);
  if (!code) code = judge_failure(exr_decoding_run(exr, 0, &pipeline), &pipeline);
  exr_decoding_destroy(exr, &pipeline);
  return code;
}

static neph_result decode_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  exr_reader *reader = user;
  for (size_t i = begin; i < end; i++) {
    exr_result_t code = decode_chunk(reader, (int)i % reader->columns, (int)i / reader->columns);
    if (code) return np_exr_remember_failure(&reader->file, code);
  }
  return NEPH_OK;
}

static neph_result read_pixels(exr_reader *reader) {
  np_exr_file *file = &reader->file;
  size_t count = (size_t)reader->columns * (size_t)reader->rows;
  neph_result result = np_parallel_for(file->context, NULL, count, 1, decode_chunks, reader);
  return result && atomic_load(&file->worker_error) ? fail_read(file, atomic_load(&file->worker_error)) : result;
}

static neph_result read_file(exr_reader *reader) {
  exr_chunk_info_t first;
  neph_result result = open_file(&reader->file);
  if (!result) result = check_kind(reader);
  if (!result) result = count_chunks(reader);
  if (result) return result;
  /* This call makes OpenEXRCore check its table of chunks against the size of the file before the picture is
     allocated. */
  exr_result_t code = read_chunk_info(reader, 0, 0, &first);
  if (code) return fail_read(&reader->file, code);
  result = read_header(&reader->file, true, &reader->image);
  return result ? result : read_pixels(reader);
}

neph_result np_image_decode_exr(neph_context *context, int descriptor, const char *path, neph_image **out_image) {
  *out_image = NULL;
  exr_reader reader = {.file = {.context = context, .path = path, .descriptor = descriptor}};
  neph_result result = read_file(&reader);
  np_exr_close(&reader.file);
  if (!result)
    *out_image = reader.image;
  else
    neph_image_destroy(reader.image);
  return result;
}
