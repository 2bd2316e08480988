/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR through OpenEXRCore. Its streams are ours, so that the errno of a failed read or write reaches the message;
 * chunks are compressed and decompressed on the context's threads, and written in order. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openexr_decode.h>
#include <openexr_encode.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/parallel.h"
#include "image/image_private.h"

enum { ZIP_LEVEL = 4, SHORT_NAME_MAX = 31 };

/* A file open in OpenEXRCore. */
typedef struct exr_file {
  neph_context *context;
  const char *path; /* for messages */
  exr_context_t exr;
  int descriptor;
  atomic_int stream_error; /* errno of the last failed read or write; 0: none failed */
  atomic_int worker_error; /* exr_result_t of a chunk that failed on a worker thread */
  atomic_bool has_complaint;
  char complaint[256]; /* what the library said first */
} exr_file;

/* ---- Streams and errors ---- */

static int64_t get_file_size(exr_const_context_t exr, void *user) {
  (void)exr;
  struct stat status;
  return fstat(((exr_file *)user)->descriptor, &status) ? -1 : (int64_t)status.st_size;
}

static int64_t read_bytes(exr_const_context_t exr, void *user, void *bytes, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t report) {
  (void)exr, (void)report;
  exr_file *file = user;
  uint64_t done = 0;
  while (done < size) {
    ssize_t count = pread(file->descriptor, (char *)bytes + done, size - done, (off_t)(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return atomic_store(&file->stream_error, errno), -1;
    if (count == 0) break;
    done += (uint64_t)count;
  }
  return (int64_t)done;
}

static int64_t write_bytes(exr_const_context_t exr, void *user, const void *bytes, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t report) {
  (void)exr, (void)report;
  exr_file *file = user;
  uint64_t done = 0;
  while (done < size) {
    ssize_t count = pwrite(file->descriptor, (const char *)bytes + done, size - done, (off_t)(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return atomic_store(&file->stream_error, errno), -1;
    done += (uint64_t)count;
  }
  return (int64_t)done;
}

/* Keeps the first complaint for the message. For reading alone: a context open for writing holds its lock while it
 * complains, and asking it for the user data would wait for that lock for ever. */
static void keep_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)code;
  void *user = NULL;
  if (!exr || exr_get_user_data(exr, &user) || !user) return;
  exr_file *file = user;
  if (!atomic_exchange(&file->has_complaint, true)) snprintf(file->complaint, sizeof file->complaint, "%s", message);
}

static void ignore_complaint(exr_const_context_t exr, exr_result_t code, const char *message) {
  (void)exr, (void)code, (void)message;
}

/* The library begins each message with the name of the file. */
static const char *describe_complaint(const exr_file *file, exr_result_t code) {
  if (!file->complaint[0]) return exr_get_default_error_message(code);
  const char *name_end = strstr(file->complaint, "': ");
  return file->complaint[0] == '\'' && name_end ? name_end + 3 : file->complaint;
}

static neph_result fail_read(exr_file *file, exr_result_t code) {
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

static neph_result fail_write(exr_file *file, exr_result_t code) {
  int error = atomic_load(&file->stream_error);
  if (error) return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: %s", file->path, strerror(error));
  if (code == EXR_ERR_OUT_OF_MEMORY)
    return np_fail(file->context, NEPH_ERROR_OUT_OF_MEMORY, "%s: no memory to encode it", file->path);
  return np_fail(file->context, NEPH_ERROR_IO, "%s: cannot be written: OpenEXR: %s", file->path,
                 exr_get_default_error_message(code));
}

/* A worker's failure is told once, after the loop. */
static neph_result remember_worker_error(exr_file *file, exr_result_t code) {
  int none = EXR_ERR_SUCCESS;
  atomic_compare_exchange_strong(&file->worker_error, &none, code);
  return code == EXR_ERR_OUT_OF_MEMORY ? NEPH_ERROR_OUT_OF_MEMORY : NEPH_ERROR_BAD_FILE;
}

static void close_file(exr_file *file) {
  if (file->exr) exr_finish(&file->exr);
  if (file->descriptor >= 0) close(file->descriptor);
  file->descriptor = -1;
}

/* An image's channel in memory: floats, line after line. */
static void lay_out_values(const neph_image *image, exr_coding_channel_info_t *channel) {
  channel->user_bytes_per_element = sizeof(float);
  channel->user_data_type = EXR_PIXEL_FLOAT;
  channel->user_pixel_stride = sizeof(float);
  channel->user_line_stride = (int32_t)(image->width * sizeof(float));
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

static exr_result_t set_required(exr_context_t exr, const neph_image *image) {
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
                                                   EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP);
  return code ? code : exr_set_zip_compression_level(exr, 0, ZIP_LEVEL);
}

/* Longer names need a flag that old readers refuse. */
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
  return code ? code : exr_attr_set_m44f(exr, 0, "worldToNDC", &ndc);
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
  snprintf(software, sizeof software, "nephos %s", neph_version_get_text());
  exr_result_t code = exr_attr_set_string(exr, 0, "software", software);
  if (!code && image->header.has_camera) code = set_camera(exr, &image->header);
  if (!code && image->header.has_chromaticities) {
    exr_attr_chromaticities_t chromaticities;
    memcpy(&chromaticities, image->header.chromaticities, sizeof chromaticities);
    code = exr_attr_set_chromaticities(exr, 0, "chromaticities", &chromaticities);
  }
  for (unsigned a = 0; !code && a < image->attribute_count; a++) code = set_attribute(exr, &image->attributes[a]);
  return code;
}

static exr_result_t write_header(exr_context_t exr, const neph_image *image, neph_pixel_type pixel_type) {
  int part;
  exr_result_t code = exr_set_longname_support(exr, has_long_names(image));
  if (!code) code = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
  if (!code) code = set_required(exr, image);
  for (unsigned c = 0; !code && c < image->channel_count; c++)
    code = exr_add_channel(exr, 0, image->channels[c].name, choose_pixel_type(&image->channels[c], pixel_type),
                           EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
  if (!code) code = set_optional(exr, image);
  return code ? code : exr_write_header(exr);
}

/* ---- Writing the pixels ---- */

/* A compressed chunk that waits to be written in its turn. */
typedef struct exr_chunk {
  void *bytes;
  size_t size;
} exr_chunk;

typedef struct exr_writer {
  exr_file file;
  const neph_image *image;
  exr_chunk *chunks;
  int chunk_count, lines_per_chunk;
} exr_writer;

/* The file's channels are sorted by name, the image's need not be. */
static void point_to_values(const neph_image *image, size_t first, exr_encode_pipeline_t *pipeline) {
  for (int c = 0; c < pipeline->channel_count; c++) {
    exr_coding_channel_info_t *channel = &pipeline->channels[c];
    lay_out_values(image, channel);
    channel->encode_from_ptr = (const uint8_t *)(np_image_find_channel(image, channel->channel_name) + first);
  }
}

/* Leaves the compressed bytes in the pipeline, to be ended whatever the outcome. */
static exr_result_t run_pipeline(const exr_writer *writer, int line, exr_encode_pipeline_t *pipeline) {
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

static neph_result compress_chunk(exr_writer *writer, int index) {
  exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
  exr_result_t code = run_pipeline(writer, index * writer->lines_per_chunk, &pipeline);
  neph_result result = code ? remember_worker_error(&writer->file, code) : NEPH_OK;
  exr_chunk *chunk = &writer->chunks[index];
  if (!result) chunk->bytes = np_alloc(writer->file.context, pipeline.compressed_bytes, 1);
  if (chunk->bytes) {
    memcpy(chunk->bytes, pipeline.compressed_buffer, pipeline.compressed_bytes);
    chunk->size = pipeline.compressed_bytes;
  } else if (!result) {
    result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  exr_encoding_destroy(writer->file.exr, &pipeline);
  return result;
}

static neph_result compress_chunks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  neph_result result = NEPH_OK;
  for (size_t i = begin; !result && i < end; i++) result = compress_chunk(user, (int)i);
  return result;
}

static neph_result write_pixels(exr_writer *writer) {
  exr_file *file = &writer->file;
  exr_result_t code = exr_get_scanlines_per_chunk(file->exr, 0, &writer->lines_per_chunk);
  if (!code) code = exr_get_chunk_count(file->exr, 0, &writer->chunk_count);
  if (code) return fail_write(file, code);
  writer->chunks = np_alloc(file->context, (size_t)writer->chunk_count, sizeof *writer->chunks);
  if (!writer->chunks) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_parallel_for(file->context, NULL, (size_t)writer->chunk_count, 1, compress_chunks, writer);
  if (result) return atomic_load(&file->worker_error) ? fail_write(file, atomic_load(&file->worker_error)) : result;
  for (int i = 0; !code && i < writer->chunk_count; i++)
    code = exr_write_scanline_chunk(file->exr, 0, np_image_get_data_min(writer->image, 1) + i * writer->lines_per_chunk,
                                    writer->chunks[i].bytes, writer->chunks[i].size);
  return code ? fail_write(file, code) : NEPH_OK;
}

static void free_chunks(exr_writer *writer) {
  for (int i = 0; writer->chunks && i < writer->chunk_count; i++)
    np_alloc_free(writer->file.context, writer->chunks[i].bytes);
  np_alloc_free(writer->file.context, writer->chunks);
}

/* The chunk table is written when the file is finished. */
static neph_result finish_file(exr_file *file) {
  exr_result_t code = exr_finish(&file->exr);
  if (code || atomic_load(&file->stream_error)) return fail_write(file, code);
  int descriptor = file->descriptor;
  file->descriptor = -1;
  if (!close(descriptor)) return NEPH_OK;
  atomic_store(&file->stream_error, errno);
  return fail_write(file, EXR_ERR_WRITE_IO);
}

static neph_result write_file(exr_writer *writer, const char *temporary, neph_pixel_type pixel_type) {
  exr_file *file = &writer->file;
  file->descriptor = open(temporary, O_WRONLY | O_CLOEXEC);
  if (file->descriptor < 0) {
    atomic_store(&file->stream_error, errno);
    return fail_write(file, EXR_ERR_FILE_ACCESS);
  }
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = ignore_complaint;
  initializer.user_data = file;
  initializer.write_fn = write_bytes;
  exr_result_t code = exr_start_write(&file->exr, temporary, EXR_WRITE_FILE_DIRECTLY, &initializer);
  if (!code) code = write_header(file->exr, writer->image, pixel_type);
  neph_result result = code ? fail_write(file, code) : write_pixels(writer);
  free_chunks(writer);
  if (!result) result = finish_file(file);
  close_file(file);
  return result;
}

neph_result neph_image_save_exr(const neph_image *image, const char *path, neph_pixel_type pixel_type) {
  np_file_write write;
  neph_result result = np_image_check_values(image, path, pixel_type);
  if (!result) result = np_file_write_begin(image->context, path, &write);
  if (result) return result;
  exr_writer writer = {.file = {.context = image->context, .path = path, .descriptor = -1}, .image = image};
  result = write_file(&writer, write.temporary, pixel_type);
  if (!result) return np_file_write_commit(&write);
  np_file_write_abandon(&write);
  return result;
}

/* ---- Reading the header ---- */

static neph_result open_file(exr_file *file) {
  file->descriptor = open(file->path, O_RDONLY | O_CLOEXEC);
  if (file->descriptor < 0)
    return np_fail(file->context, errno == ENOENT || errno == ENOTDIR ? NEPH_ERROR_NOT_FOUND : NEPH_ERROR_IO,
                   "%s: cannot be read: %s", file->path, strerror(errno));
  exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
  initializer.error_handler_fn = keep_complaint;
  initializer.user_data = file;
  initializer.read_fn = read_bytes;
  initializer.size_fn = get_file_size;
  initializer.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
  exr_result_t code = exr_start_read(&file->exr, file->path, &initializer);
  return code ? fail_read(file, code) : NEPH_OK;
}

static neph_result check_claims(const exr_file *file, const exr_attr_box2i_t *window, int channel_count) {
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

static neph_result create_image(exr_file *file, bool has_values, neph_image **out_image) {
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

static neph_result read_windows(exr_file *file, np_image_header *header) {
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

static void read_matrices(const exr_file *file, np_image_header *header) {
  exr_attr_m44f_t camera, ndc;
  exr_attr_chromaticities_t chromaticities;
  if (!exr_attr_get_m44f(file->exr, 0, "worldToCamera", &camera) &&
      !exr_attr_get_m44f(file->exr, 0, "worldToNDC", &ndc)) {
    memcpy(header->world_to_camera, &camera, sizeof camera);
    memcpy(header->world_to_ndc, &ndc, sizeof ndc);
    header->has_camera = true;
  }
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

/* What OpenEXR itself lives by is not ours to carry from file to file. */
static bool is_structural(const char *name) {
  static const char *const names[] = {
      "name", "type", "version", "chunkCount", "view", "pixelAspectRatio", "screenWindowWidth"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (!strcmp(names[i], name)) return true;
  return false;
}

static neph_result read_attributes(exr_file *file, neph_image *image) {
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

static neph_result read_header(exr_file *file, bool has_values, neph_image **out_image) {
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

static neph_result read_info(exr_file *file, np_image_exr_info *out_info) {
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

neph_result np_image_read_exr_header(neph_context *context, const char *path, np_image_exr_info *out_info,
                                     neph_image **out_image) {
  *out_image = NULL;
  exr_file file = {.context = context, .path = path, .descriptor = -1};
  neph_result result = open_file(&file);
  if (!result) result = read_info(&file, out_info);
  if (!result) result = read_header(&file, false, out_image);
  close_file(&file);
  return result;
}

/* ---- Reading the pixels ---- */

typedef struct exr_reader {
  exr_file file;
  neph_image *image;
  bool is_tiled;
  int chunk_width, chunk_height; /* of a whole chunk; the last ones may be smaller */
  int columns, rows;             /* of chunks */
  int first_line;                /* of the data window */
} exr_reader;

static neph_result check_kind(exr_reader *reader) {
  exr_file *file = &reader->file;
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

static neph_result find_chunks(exr_reader *reader) {
  exr_file *file = &reader->file;
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
    lay_out_values(image, channel);
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
    if (code) return remember_worker_error(&reader->file, code);
  }
  return NEPH_OK;
}

static neph_result read_pixels(exr_reader *reader) {
  exr_file *file = &reader->file;
  size_t count = (size_t)reader->columns * (size_t)reader->rows;
  neph_result result = np_parallel_for(file->context, NULL, count, 1, decode_chunks, reader);
  return result && atomic_load(&file->worker_error) ? fail_read(file, atomic_load(&file->worker_error)) : result;
}

static neph_result read_file(exr_reader *reader) {
  exr_chunk_info_t first;
  neph_result result = open_file(&reader->file);
  if (!result) result = check_kind(reader);
  if (!result) result = find_chunks(reader);
  if (result) return result;
  /* Makes the library check its table of chunks against the size of the file before the picture is allocated. */
  exr_result_t code = find_chunk(reader, 0, 0, &first);
  if (code) return fail_read(&reader->file, code);
  result = read_header(&reader->file, true, &reader->image);
  return result ? result : read_pixels(reader);
}

neph_result neph_image_load_exr(neph_context *context, const char *path, neph_image **out_image) {
  *out_image = NULL;
  exr_reader reader = {.file = {.context = context, .path = path, .descriptor = -1}};
  neph_result result = read_file(&reader);
  close_file(&reader.file);
  if (!result)
    *out_image = reader.image;
  else
    neph_image_destroy(reader.image);
  return result;
}
