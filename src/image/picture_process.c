/* SPDX-License-Identifier: Apache-2.0 */
#include "image/picture_process.h"

#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/child.h"
#include "core/file.h"
#include "core/module.h"
#include "core/given.h"
#include "core/text.h"
#include "image/picture_stream.h"

static const np_module_kind picture_kind = {.file = NP_PICTURE_PROGRAM_FILE, .purpose = "reads OpenEXR and PNG"};

typedef struct picture_process {
  neph_context *context;
  const np_picture_request *request;
  const np_monitor *monitor; /* NULL: no monitor */
  uint64_t file_bytes;
  uint64_t text_bytes_left; /* limit on the bytes of names and values, which must come from the file */
  bool has_values;
  np_child child;
  np_picture_head head;
  np_image_exr_info *info; /* NULL: not requested */
  neph_image *image;
} picture_process;

/* ---- Failures ---- */

static neph_result fail(const picture_process *p, const char *reason) {
  return np_fail(p->context, NEPH_ERROR_BAD_FILE, "%s: cannot be read: %s", p->request->path, reason);
}

static neph_result fail_by_signal(const picture_process *p, int signal) {
  if (signal == SIGXCPU)
    return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                   "%s: cannot be read: its decoder took more than %u s and 1 s for each %u MB of file and pixels: it "
                   "is damaged",
                   p->request->path, NP_PICTURE_TIME_S, NP_PICTURE_TIME_BYTES_PER_S / 1000000);
  return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                 "%s: cannot be read: its decoder ended by the signal SIG%s: it is damaged", p->request->path,
                 sigabbrev_np(signal) ? sigabbrev_np(signal) : "");
}

static neph_result fail_by_end(picture_process *p) {
  enum { NOT_STARTED = 127 /* the dynamic linker failed */ };
  const int status = np_child_wait(&p->child);
  if (status != -1 && WIFSIGNALED(status)) return fail_by_signal(p, WTERMSIG(status));
  if (status != -1 && WIFEXITED(status) && WEXITSTATUS(status) == NOT_STARTED)
    return np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "%s: cannot be read: libraries of %s, which %s, are missing",
                   p->request->path, picture_kind.file, picture_kind.purpose);
  return fail(p, "its decoder ended before it was done: it is damaged");
}

/* Fails for an answer that an intact decoder never gives: a crafted file may control the process. */
static neph_result fail_by_answer(const picture_process *p) {
  return fail(p, "its decoder gave a wrong answer: it is damaged");
}

static neph_result get(picture_process *p, void *out, size_t count) {
  const neph_result result = np_child_read(&p->child, p->context, p->monitor, out, count);
  return result == NEPH_ERROR_BAD_FILE ? fail_by_end(p) : result;
}

/* Whether a decoder can return this result. */
static bool is_decoder_result(uint32_t result) {
  return result == NEPH_ERROR_OUT_OF_MEMORY || result == NEPH_ERROR_INVALID_ARGUMENT || result == NEPH_ERROR_IO ||
         result == NEPH_ERROR_BAD_FILE || result == NEPH_ERROR_LIMIT || result == NEPH_ERROR_UNSUPPORTED;
}

/* Fails with the decoder's message, which names the file. */
static neph_result fail_by_message(picture_process *p, const np_picture_start *start) {
  char message[NP_PICTURE_MESSAGE_BYTES] = "";
  if (!start->message_length || start->message_length >= sizeof message || !is_decoder_result(start->result))
    return fail_by_answer(p);
  const neph_result result = get(p, message, start->message_length);
  if (result) return result;
  for (char *at = message; (at = strpbrk(at, "\n\r"));) *at = ' ';
  return np_fail(p->context, (neph_result)start->result, "%s", message);
}

/* ---- Answers ---- */

static neph_result read_start(picture_process *p) {
  np_picture_start start;
  const neph_result result = get(p, &start, sizeof start);
  if (result) return result;
  if (start.version != NP_PICTURE_STREAM_VERSION)
    return np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "%s: cannot be read: %s is of another version of nephos",
                   p->request->path, picture_kind.file);
  return start.result || start.message_length ? fail_by_message(p, &start) : NEPH_OK;
}

static bool is_window(const int32_t min[2], const int32_t max[2], const uint32_t size[2]) {
  for (int a = 0; a < 2; a++)
    if (max[a] < min[a] || (size && (int64_t)max[a] - min[a] + 1 != size[a])) return false;
  return true;
}

/* Checks the first record of the answer. The windows of a PNG are zeros. */
static neph_result check_head(const picture_process *p) {
  enum { ATTRIBUTES_MAX = 65536 };
  const np_picture_head *h = &p->head;
  const uint32_t size[2] = {h->width, h->height};
  const bool has_windows = h->data_max[0] || h->data_max[1] || h->data_min[0] || h->data_min[1] || h->has_window;
  const bool is_good = (h->has_camera | h->has_ndc | h->is_latlong | h->has_chromaticities | h->has_window) <= 1 &&
                       h->storage < NP_PICTURE_WORDS && h->compression < NP_PICTURE_WORDS && h->part_count >= 0 &&
                       h->attribute_count <= ATTRIBUTES_MAX && h->width <= INT_MAX && h->height <= INT_MAX &&
                       h->channel_count <= NP_IMAGE_CHANNELS_MAX &&
                       (!has_windows || is_window(h->data_min, h->data_max, size));
  if (!is_good) return fail_by_answer(p);
  return np_image_check_claims(p->context, p->request->path, h->width, h->height, (int)h->channel_count);
}

/* Reads a text of `length` bytes, which np_alloc_free frees. */
static neph_result get_text(picture_process *p, uint64_t length, char **out_text) {
  *out_text = NULL;
  if (length > p->text_bytes_left) return fail_by_answer(p);
  p->text_bytes_left -= length;
  char *text = np_alloc(p->context, length + 1, 1);
  if (!text) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = get(p, text, length);
  if (result)
    np_alloc_free(p->context, text);
  else
    *out_text = text;
  return result;
}

static neph_result get_channel(picture_process *p, char **out_name, const char **out_stored) {
  np_picture_channel channel;
  neph_result result = get(p, &channel, sizeof channel);
  if (result) return result;
  if (channel.stored >= NP_PICTURE_WORDS || !channel.name_length || channel.name_length > NP_IMAGE_NAME_MAX)
    return fail_by_answer(p);
  *out_stored = np_picture_words[channel.stored];
  return get_text(p, channel.name_length, out_name);
}

static neph_result make_image(picture_process *p, char **names, const char **stored) {
  const np_picture_head *h = &p->head;
  neph_result result = NEPH_OK;
  for (uint32_t c = 0; !result && c < h->channel_count; c++) result = get_channel(p, &names[c], &stored[c]);
  if (!result)
    result = np_image_create(p->context, h->width, h->height, h->channel_count, (const char *const *)names,
                             p->has_values, &p->image);
  for (uint32_t c = 0; !result && c < h->channel_count; c++) p->image->channels[c].stored = stored[c];
  return result;
}

static neph_result read_channels(picture_process *p) {
  const uint32_t count = p->head.channel_count;
  char **names = np_alloc(p->context, count, sizeof *names);
  const char **stored = names ? np_alloc(p->context, count, sizeof *stored) : NULL;
  const neph_result result = stored ? make_image(p, names, stored) : NEPH_ERROR_OUT_OF_MEMORY;
  for (uint32_t c = 0; names && c < count; c++) np_alloc_free(p->context, names[c]);
  np_alloc_free(p->context, names);
  np_alloc_free(p->context, stored);
  return result;
}

static neph_result set_attribute(picture_process *p, const np_picture_attribute *a, const char *name,
                                 const char *value) {
  if (a->type == NP_IMAGE_TEXT) return neph_image_set_attribute(p->image, name, value);
  if (a->type == NP_IMAGE_REAL) return np_image_set_real(p->image, name, a->number);
  if (!(a->number >= INT_MIN && a->number <= INT_MAX)) return fail_by_answer(p);
  return np_image_set_integer(p->image, name, (int32_t)a->number);
}

static neph_result read_attribute(picture_process *p) {
  np_picture_attribute attribute;
  char *name = NULL, *value = NULL;
  neph_result result = get(p, &attribute, sizeof attribute);
  if (!result && (attribute.type > NP_IMAGE_REAL || !attribute.name_length)) result = fail_by_answer(p);
  if (!result) result = get_text(p, attribute.name_length, &name);
  if (!result) result = get_text(p, attribute.value_length, &value);
  if (!result) result = set_attribute(p, &attribute, name, value);
  np_alloc_free(p->context, name);
  np_alloc_free(p->context, value);
  return result;
}

static void copy_head(picture_process *p) {
  const np_picture_head *h = &p->head;
  np_image_header *out = &p->image->header;
  out->has_camera = h->has_camera, out->has_ndc = h->has_ndc, out->is_latlong = h->is_latlong;
  out->has_chromaticities = h->has_chromaticities, out->has_window = h->has_window;
  memcpy(out->world_to_camera, h->world_to_camera, sizeof out->world_to_camera);
  memcpy(out->world_to_ndc, h->world_to_ndc, sizeof out->world_to_ndc);
  memcpy(out->chromaticities, h->chromaticities, sizeof out->chromaticities);
  for (int a = 0; a < 2; a++) {
    out->data_min[a] = h->data_min[a], out->data_max[a] = h->data_max[a];
    out->display_min[a] = h->display_min[a], out->display_max[a] = h->display_max[a];
  }
  if (!p->info) return;
  *p->info = (np_image_exr_info){np_picture_words[h->storage], np_picture_words[h->compression], h->part_count,
                                 h->tile_width, h->tile_height};
}

static neph_result read_answer(picture_process *p) {
  neph_result result = read_start(p);
  if (!result) result = get(p, &p->head, sizeof p->head);
  if (!result) result = check_head(p);
  if (!result) result = read_channels(p);
  if (!result) copy_head(p);
  for (uint32_t i = 0; !result && i < p->head.attribute_count; i++) result = read_attribute(p);
  const size_t plane_bytes = (size_t)p->head.width * p->head.height * sizeof(float);
  for (uint32_t c = 0; !result && p->has_values && c < p->head.channel_count; c++)
    result = get(p, p->image->channels[c].values, plane_bytes);
  return result;
}

/* ---- Begin and end ---- */

/* Number of threads to decompress chunks: a small file has few chunks, and a limit on address space leaves no room for
 * stacks. */
static unsigned choose_threads(const picture_process *p) {
  enum { BYTES_PER_THREAD = 1 << 18 };
  const unsigned count = np_foreign_thread_count(p->context);
  const uint64_t useful = 1 + p->file_bytes / BYTES_PER_THREAD;
  return useful < count ? (unsigned)useful : count;
}

static neph_result start(picture_process *p, int file) {
  char program[PATH_MAX], threads[16];
  neph_result result = NEPH_OK;
  if (p->request->program)
    np_print(program, sizeof program, "%s", p->request->program);
  else
    result = np_module_get_program(p->context, &picture_kind, program);
  if (result) return result;
  np_print(threads, sizeof threads, "%u", choose_threads(p));
  const char *const words[] = {p->request->word, p->request->path, threads, NULL};
  const int error = np_child_start_on(program, words, file, &p->child);
  return error ? np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "cannot start %s, which %s: %s", program,
                         picture_kind.purpose, strerrordesc_np(error))
               : NEPH_OK;
}

static neph_result run(void *user) {
  picture_process *p = user;
  const char *reason;
  int file;
  neph_result result = np_file_open(p->request->path, &file, &reason);
  if (result) return np_fail(p->context, result, "%s: cannot be read: %s", p->request->path, reason);
  p->file_bytes = np_file_get_size(p->request->path);
  p->text_bytes_left = 4 * p->file_bytes + 4096; /* numbers are longer as text than in the file */
  result = start(p, file);
  close(file);
  if (!result) result = read_answer(p);
  np_child_end(&p->child);
  return result;
}

neph_result np_picture_read(neph_context *context, const np_picture_request *request, np_monitor *monitor,
                            np_image_exr_info *out_info, neph_image **out_image) {
  picture_process p = {.context = context,
                       .request = request,
                       .monitor = monitor,
                       .has_values = strcmp(request->word, "exr-header") != 0,
                       .child.output = -1,
                       .info = out_info};
  *out_image = NULL;
  const neph_result result = np_parallel_run(context, monitor, run, &p);
  if (!result)
    *out_image = p.image;
  else
    neph_image_destroy(p.image);
  return result;
}

/* ---- Pictures ---- */

neph_result np_image_load_exr(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image) {
  return np_picture_read(context, &(np_picture_request){"exr", path, NULL}, monitor, NULL, out_image);
}

neph_result np_image_load_png(neph_context *context, const char *path, np_monitor *monitor, neph_image **out_image) {
  return np_picture_read(context, &(np_picture_request){"png", path, NULL}, monitor, NULL, out_image);
}

neph_result np_image_read_exr_header(neph_context *context, const char *path, np_image_exr_info *out_info,
                                     neph_image **out_image) {
  return np_picture_read(context, &(np_picture_request){"exr-header", path, NULL}, NULL, out_info, out_image);
}

neph_result neph_image_load_exr(neph_context *context, const char *path, neph_image **out_image) {
  if (NP_LACKS_OUT(context, out_image, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_image_load_exr(context, path, NULL, out_image);
}

neph_result neph_image_load_png(neph_context *context, const char *path, neph_image **out_image) {
  if (NP_LACKS_OUT(context, out_image, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_image_load_png(context, path, NULL, out_image);
}
