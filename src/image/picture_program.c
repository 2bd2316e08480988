/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_pictures: decodes the picture on its standard input, and writes the records of picture_stream.h to
 * its standard output. It limits its rights before it reads the file, and exits without freeing memory. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/picture_decoder.h"
#include "image/picture_sandbox.h"
#include "image/picture_stream.h"
#include "core/text.h"

/* ---- Answers ---- */

static void put(const void *bytes, size_t size, size_t count) { (void)fwrite(bytes, size, count, stdout); }

/* Writes a plane past the stream's buffer. */
static void put_plane(const float *values, size_t count) {
  const char *at = (const char *)values;
  for (size_t left = fflush(stdout) ? 0 : count * sizeof *values; left > 0;) {
    const ssize_t written = write(STDOUT_FILENO, at, left);
    if (written < 0 && errno != EINTR) _exit(EXIT_FAILURE);
    if (written > 0) at += written, left -= (size_t)written;
  }
}

static uint32_t get_word(const char *word) {
  for (uint32_t i = 0; word && i < NP_PICTURE_WORDS; i++)
    if (!strcmp(np_picture_words[i], word)) return i;
  return 0;
}

static void put_start(uint32_t result, const char *message) {
  const np_picture_start start = {NP_PICTURE_STREAM_VERSION, result,
                                  (uint32_t)strnlen(message, NP_PICTURE_MESSAGE_BYTES - 1)};
  put(&start, sizeof start, 1);
  put(message, 1, start.message_length);
}

static void put_head(const neph_image *image, const np_image_exr_info *info) {
  const np_image_header *h = &image->header;
  np_picture_head head = {.width = image->width,
                          .height = image->height,
                          .channel_count = image->channel_count,
                          .attribute_count = image->attribute_count,
                          .has_camera = h->has_camera,
                          .has_ndc = h->has_ndc,
                          .is_latlong = h->is_latlong,
                          .has_chromaticities = h->has_chromaticities,
                          .has_window = h->has_window,
                          .storage = get_word(info->storage),
                          .compression = get_word(info->compression),
                          .part_count = info->part_count,
                          .tile_width = info->tile_width,
                          .tile_height = info->tile_height};
  memcpy(head.world_to_camera, h->world_to_camera, sizeof head.world_to_camera);
  memcpy(head.world_to_ndc, h->world_to_ndc, sizeof head.world_to_ndc);
  memcpy(head.chromaticities, h->chromaticities, sizeof head.chromaticities);
  for (int a = 0; a < 2; a++) {
    head.data_min[a] = h->data_min[a], head.data_max[a] = h->data_max[a];
    head.display_min[a] = h->display_min[a], head.display_max[a] = h->display_max[a];
  }
  put(&head, sizeof head, 1);
}

static void put_channel(const np_image_channel *channel) {
  const np_picture_channel record = {get_word(channel->stored), (uint32_t)strlen(channel->name)};
  put(&record, sizeof record, 1);
  put(channel->name, 1, record.name_length);
}

static void put_attribute(const np_image_attribute *attribute) {
  const np_picture_attribute record = {attribute->type, (uint32_t)strlen(attribute->name), strlen(attribute->value),
                                       attribute->number};
  put(&record, sizeof record, 1);
  put(attribute->name, 1, record.name_length);
  put(attribute->value, 1, record.value_length);
}

static void put_image(const neph_image *image, const np_image_exr_info *info) {
  put_start(NEPH_OK, "");
  put_head(image, info);
  for (unsigned c = 0; c < image->channel_count; c++) put_channel(&image->channels[c]);
  for (unsigned i = 0; i < image->attribute_count; i++) put_attribute(&image->attributes[i]);
  for (unsigned c = 0; c < image->channel_count; c++)
    if (image->channels[c].values) put_plane(image->channels[c].values, (size_t)image->width * image->height);
}

/* ---- Requests ---- */

typedef struct request {
  neph_context *context;
  const char *path;                       /* path in messages */
  char message[NP_PICTURE_MESSAGE_BYTES]; /* first error */
} request;

static void store_error(void *user, neph_log_level level, const char *message) {
  request *r = user;
  if (level == NEPH_LOG_ERROR && !r->message[0]) np_print_short(r->message, sizeof r->message, message);
}

static neph_result decode_exr(request *r, int file, np_image_exr_info *out_info, neph_image **out_image) {
  (void)out_info;
  return np_image_decode_exr(r->context, file, r->path, out_image);
}

static neph_result decode_exr_header(request *r, int file, np_image_exr_info *out_info, neph_image **out_image) {
  return np_image_decode_exr_header(r->context, file, r->path, out_info, out_image);
}

static neph_result decode_png(request *r, int file, np_image_exr_info *out_info, neph_image **out_image) {
  (void)out_info;
  return np_image_decode_png(r->context, file, r->path, out_image);
}

/* Bytes of the pixels of a PNG, from its width and height. */
static uint64_t count_png_bytes(request *r, int file) {
  enum { SIZE_AT = 16, CHANNELS_MAX = 4, BYTES = sizeof(float) + 2 /* a sample in memory, and as stored */ };
  unsigned char b[8] = {0};
  (void)r;
  if (pread(file, b, sizeof b, SIZE_AT) != sizeof b) return 0;
  const uint64_t width = (uint64_t)b[0] << 24 | (uint64_t)b[1] << 16 | (uint64_t)b[2] << 8 | b[3];
  const uint64_t height = (uint64_t)b[4] << 24 | (uint64_t)b[5] << 16 | (uint64_t)b[6] << 8 | b[7];
  if (width > NP_IMAGE_SIDE_MAX || height > NP_IMAGE_SIDE_MAX) return 0;
  return width * height * CHANNELS_MAX * BYTES;
}

/* Bytes of the pixels of an EXR. A failure here occurs again when the picture is read. */
static uint64_t count_exr_bytes(request *r, int file) {
  np_image_exr_info info;
  neph_image *image;
  if (np_image_decode_exr_header(r->context, file, r->path, &info, &image)) return r->message[0] = 0, 0;
  return (uint64_t)image->width * image->height * image->channel_count * sizeof(float);
}

static uint64_t count_nothing(request *r, int file) { return (void)r, (void)file, 0; }

static const struct {
  const char *word;
  neph_result (*decode)(request *r, int file, np_image_exr_info *out_info, neph_image **out_image);
  uint64_t (*count_bytes)(request *r, int file); /* counts the bytes of the claimed pixels */
} requests[] = {{"exr", decode_exr, count_exr_bytes},
                {"exr-header", decode_exr_header, count_nothing},
                {"png", decode_png, count_png_bytes}};

/* ---- Program ---- */

static void limit(const np_picture_sandbox *sandbox, uint64_t bytes, unsigned threads) {
  np_picture_sandbox_limit(sandbox,
                           NP_PICTURE_ROOM_BYTES + threads * NP_PICTURE_ROOM_BYTES_PER_THREAD + bytes + bytes / 4,
                           NP_PICTURE_TIME_S + bytes / NP_PICTURE_TIME_BYTES_PER_S);
}

static uint64_t get_file_bytes(void) {
  struct stat status;
  return fstat(STDIN_FILENO, &status) || status.st_size < 0 ? 0 : (uint64_t)status.st_size;
}

/* Decodes the picture, limited by its file's size before the header is read, and by its pixels afterwards. Each reader
 * closes its copy of the input. */
static void decode(request *r, size_t index, unsigned threads) {
  const int copies[] = {dup(STDIN_FILENO), dup(STDIN_FILENO)};
  const uint64_t file_bytes = get_file_bytes();
  np_image_exr_info info = {.part_count = 0};
  neph_image *image = NULL;
  const np_picture_sandbox sandbox = np_picture_sandbox_begin();
  limit(&sandbox, 2 * file_bytes, threads);
  const uint64_t pixel_bytes = requests[index].count_bytes(r, copies[0]);
  limit(&sandbox, 2 * file_bytes + pixel_bytes, threads);
  const neph_result result = requests[index].decode(r, copies[1], &info, &image);
  if (result)
    put_start(result, r->message);
  else
    put_image(image, &info);
}

static void answer(size_t index, const char *path, unsigned threads) {
  static request r;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = threads;
  desc.log = store_error;
  desc.log_user = &r;
  r.path = path;
  const neph_result result = neph_context_create(&desc, &r.context);
  if (result)
    put_start(result, r.message);
  else
    decode(&r, index, threads);
}

int main(int count, char **words) {
  enum { REQUEST = 1, PATH, THREADS, WORDS };
  for (size_t i = 0; count == WORDS && i < sizeof requests / sizeof *requests; i++)
    if (!strcmp(words[REQUEST], requests[i].word)) {
      answer(i, words[PATH], (unsigned)strtoul(words[THREADS], NULL, 10));
      _exit(fflush(stdout) ? EXIT_FAILURE : EXIT_SUCCESS);
    }
  (void)fprintf(stderr, "nephos_pictures: reads pictures for libnephos, and is not run by hand\n");
  return EXIT_FAILURE;
}
