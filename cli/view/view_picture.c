/* SPDX-License-Identifier: Apache-2.0 */
#include "view_picture.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "view_channel.h"
#include "view_clock.h"
#include "view_enlarge.h"

enum { PIXEL_BYTES = 4 };
static const double tile_interval_s = 0.06;

struct cli_view_picture {
  neph_context *context;
  pthread_mutex_t lock;
  pthread_mutex_t texts_lock; /* guards stage, message and fraction: messages come while pixels are developed */
  void (*wake)(void *user);
  void *wake_user;
  neph_preview_desc preview;      /* its texts are the picture's own: scenes that lend them come and go */
  neph_image *image;              /* last complete picture; NULL before the first */
  char *channel;                  /* channel that is shown; NULL: the picture itself */
  cli_view_channel shown_channel; /* range of its colours; its image is NULL between developments */
  double stops;                   /* exposure of the pixels; tiles are developed by that of the picture before them */
  uint8_t *pixels;
  unsigned width, height;
  unsigned long long number, preview_number;
  cli_view_step step;
  double shown_s, tiles_s; /* times of the last change and of the last tile on the page */
  bool has_tiles;          /* tiles lie over the last complete picture */
  neph_image_error error;
  char *stage, *message;
  double fraction;
};

enum { PREVIEW_TEXT_COUNT = 4 };
#define PREVIEW_TEXTS(preview)                                                                                         \
  { &(preview)->ocio_config, &(preview)->ocio_display, &(preview)->ocio_view, &(preview)->ocio_input }

/* Frees the texts of a preview. */
static void clear_preview(neph_preview_desc *preview) {
  const char **texts[] = PREVIEW_TEXTS(preview);
  for (size_t i = 0; i < PREVIEW_TEXT_COUNT; i++) free((char *)(uintptr_t)*texts[i]);
  *preview = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
}

/* Replaces a preview by a copy with texts of its own. */
static neph_result copy_preview(neph_preview_desc *preview, const neph_preview_desc *by) {
  neph_preview_desc copy = *by;
  const char **texts[] = PREVIEW_TEXTS(&copy);
  bool is_whole = true;
  for (size_t i = 0; i < PREVIEW_TEXT_COUNT; i++) {
    const char *lent = *texts[i];
    *texts[i] = lent ? strdup(lent) : NULL;
    is_whole = is_whole && (*texts[i] || !lent);
  }
  if (!is_whole) return clear_preview(&copy), NEPH_ERROR_OUT_OF_MEMORY;
  clear_preview(preview);
  *preview = copy;
  return NEPH_OK;
}

cli_view_picture *cli_view_picture_create(neph_context *context, void (*wake)(void *user), void *user) {
  cli_view_picture *picture = calloc(1, sizeof *picture);
  if (!picture) return NULL;
  pthread_mutex_init(&picture->lock, NULL);
  pthread_mutex_init(&picture->texts_lock, NULL);
  picture->context = context;
  picture->wake = wake;
  picture->wake_user = user;
  picture->preview = (neph_preview_desc)NEPH_PREVIEW_DESC_DEFAULT;
  picture->error = (neph_image_error){.struct_size = sizeof picture->error,
                                      .error = {NAN, NAN, NAN},
                                      .noise = {NAN, NAN, NAN},
                                      .bias = {NAN, NAN, NAN}};
  return picture;
}

void cli_view_picture_destroy(cli_view_picture *picture) {
  if (!picture) return;
  pthread_mutex_destroy(&picture->lock);
  pthread_mutex_destroy(&picture->texts_lock);
  neph_image_destroy(picture->image);
  free(picture->pixels);
  free(picture->channel);
  clear_preview(&picture->preview);
  free(picture->stage);
  free(picture->message);
  free(picture);
}

static void lock(cli_view_picture *picture) { pthread_mutex_lock(&picture->lock); }

static void unlock(cli_view_picture *picture) { pthread_mutex_unlock(&picture->lock); }

/* ---- Pixels ---- */

/* Sets the size on the page; the pixels of another size are lost. */
static neph_result resize(cli_view_picture *picture, unsigned width, unsigned height) {
  if (picture->width == width && picture->height == height) return NEPH_OK;
  free(picture->pixels);
  picture->pixels = calloc((size_t)width * height, PIXEL_BYTES);
  picture->width = picture->pixels ? width : 0;
  picture->height = picture->pixels ? height : 0;
  return picture->pixels ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* The wanted preview with the exposure of the last complete picture. */
static neph_preview_desc get_held_preview(const cli_view_picture *picture) {
  neph_preview_desc held = picture->preview;
  held.exposure = NEPH_EXPOSURE_FIXED;
  held.exposure_ev = picture->stops;
  return held;
}

/* Develops a smaller picture and enlarges it to the page. */
static neph_result develop_enlarged(cli_view_picture *picture, const neph_image *image, const neph_preview_desc *held) {
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  uint8_t *small = malloc((size_t)width * height * PIXEL_BYTES);
  if (!small) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = neph_image_develop(image, held, 0, 0, width, height, small, (size_t)width * PIXEL_BYTES);
  if (!result) cli_view_enlarge(small, width, height, picture->pixels, picture->width, picture->height);
  free(small);
  return result;
}

/* Develops a picture into the page's pixels. */
static neph_result develop_image(cli_view_picture *picture, const neph_image *image, const neph_preview_desc *held) {
  if (neph_image_get_width(image) != picture->width) return develop_enlarged(picture, image, held);
  return neph_image_develop(image, held, 0, 0, picture->width, picture->height, picture->pixels,
                            (size_t)picture->width * PIXEL_BYTES);
}

/* Develops the chosen channel: colours with the exposure of the picture, single numbers without exposure. */
static neph_result develop_channel(cli_view_picture *picture, neph_preview_desc held) {
  cli_view_channel *channel = &picture->shown_channel;
  neph_result result = cli_view_channel_create(picture->context, picture->image, picture->channel, channel);
  if (result) return result;
  if (channel->is_scalar) held.view = NEPH_VIEW_RAW, held.exposure_ev = 0.0;
  result = develop_image(picture, channel->image, &held);
  neph_image_destroy(channel->image);
  channel->image = NULL;
  return result;
}

/* Develops the last complete picture. */
static neph_result develop(cli_view_picture *picture) {
  neph_result result = neph_image_compute_exposure(picture->image, &picture->preview, &picture->stops);
  if (result) return result;
  const neph_preview_desc held = get_held_preview(picture);
  picture->shown_channel = (cli_view_channel){0};
  if (picture->channel && (result = develop_channel(picture, held)) != NEPH_ERROR_NOT_FOUND) return result;
  return develop_image(picture, picture->image, &held);
}

static void note_change(cli_view_picture *picture, const cli_view_step *step) {
  picture->step = *step;
  picture->shown_s = cli_view_clock_get_s();
  picture->number++;
}

neph_result cli_view_picture_show(cli_view_picture *picture, const cli_view_step *step, neph_image *image) {
  lock(picture);
  neph_image_destroy(picture->image);
  picture->image = image;
  picture->has_tiles = false;
  picture->error = (neph_image_error)NEPH_IMAGE_ERROR_DEFAULT;
  neph_result result = neph_image_get_error(image, &picture->error);
  if (!result) result = resize(picture, step->width, step->height);
  if (!result) result = develop(picture);
  if (!result) note_change(picture, step);
  if (result) { /* without colours, say: nothing can be shown until the next picture */
    neph_image_destroy(picture->image);
    picture->image = NULL;
  }
  unlock(picture);
  picture->wake(picture->wake_user);
  return result;
}

neph_result cli_view_picture_show_tile(cli_view_picture *picture, const cli_view_step *step, const neph_tile *tile) {
  lock(picture);
  neph_preview_desc held = get_held_preview(picture);
  held.glare = 0.0; /* light of the whole picture, which is developed when it is complete */
  const size_t stride = (size_t)picture->width * PIXEL_BYTES;
  uint8_t *first = picture->pixels + tile->min[1] * stride + (size_t)tile->min[0] * PIXEL_BYTES;
  const bool fits = !picture->channel && tile->max[0] <= picture->width && tile->max[1] <= picture->height;
  const neph_result result = fits ? neph_image_develop(tile->image, &held, tile->min[0], tile->min[1], tile->max[0],
                                                       tile->max[1], first, stride)
                                  : NEPH_OK;
  const double now_s = cli_view_clock_get_s();
  const bool is_due = !result && fits && now_s - picture->tiles_s >= tile_interval_s;
  picture->has_tiles |= fits;
  if (is_due) {
    picture->tiles_s = now_s;
    note_change(picture, step);
  }
  unlock(picture);
  if (is_due) picture->wake(picture->wake_user);
  return result;
}

neph_result cli_view_picture_set_preview(cli_view_picture *picture, const neph_preview_desc *preview) {
  lock(picture);
  neph_result result = copy_preview(&picture->preview, preview);
  picture->preview_number++;
  if (picture->image && !result) result = develop(picture);
  if (picture->image && !result) picture->number++;
  unlock(picture);
  picture->wake(picture->wake_user);
  return result;
}

neph_result cli_view_picture_save(cli_view_picture *picture, const char *path, bool is_exr) {
  lock(picture);
  neph_result result = NEPH_ERROR_NOT_FOUND;
  if (picture->image && is_exr) result = neph_image_save_exr(picture->image, path, NEPH_PIXEL_HALF);
  if (picture->image && !is_exr) result = neph_image_save_png(picture->image, path, &picture->preview);
  unlock(picture);
  return result;
}

/* ---- State ---- */

static void replace(char **text, const char *by) {
  char *copy = by ? strdup(by) : NULL;
  free(*text);
  *text = copy;
}

neph_result cli_view_picture_set_channel(cli_view_picture *picture, const char *name) {
  lock(picture);
  replace(&picture->channel, *name ? name : NULL);
  const neph_result result = picture->image ? develop(picture) : NEPH_OK;
  if (picture->image && !result) picture->number++;
  unlock(picture);
  picture->wake(picture->wake_user);
  return result;
}

void cli_view_picture_write_channels(cli_view_picture *picture, FILE *out) {
  lock(picture);
  if (picture->image)
    cli_view_channel_write_names(picture->image, out);
  else
    fputs("[]", out);
  unlock(picture);
}

void cli_view_picture_set_stage(cli_view_picture *picture, const char *stage, double fraction) {
  pthread_mutex_lock(&picture->texts_lock);
  if (!picture->stage || strcmp(picture->stage, stage)) replace(&picture->stage, stage);
  picture->fraction = fraction;
  pthread_mutex_unlock(&picture->texts_lock);
}

void cli_view_picture_set_message(cli_view_picture *picture, const char *message) {
  pthread_mutex_lock(&picture->texts_lock);
  replace(&picture->message, message);
  pthread_mutex_unlock(&picture->texts_lock);
}

unsigned long long cli_view_picture_get_number(cli_view_picture *picture) {
  lock(picture);
  const unsigned long long number = picture->number;
  unlock(picture);
  return number;
}

static void write_number(FILE *out, const char *name, double value) {
  fprintf(out, isfinite(value) ? ",\"%s\":%.6g" : ",\"%s\":null", name, value);
}

static void write_text(FILE *out, const char *name, const char *text) {
  fprintf(out, ",\"%s\":", name);
  cli_put_json_text(out, text ? text : "");
}

void cli_view_picture_write_state(cli_view_picture *picture, FILE *out) {
  static const char *const sources[] = {
      [NEPH_BIAS_UNKNOWN] = "unknown", [NEPH_BIAS_BY_MODEL] = "by model", [NEPH_BIAS_MEASURED] = "measured"};
  lock(picture);
  fprintf(out, "\"number\":%llu,\"generation\":%llu,\"preview\":%llu,\"level\":%u,\"width\":%u,\"height\":%u",
          picture->number, picture->step.generation, picture->preview_number, picture->step.level, picture->width,
          picture->height);
  fprintf(out, ",\"samples\":%u,\"complete\":%s", picture->step.samples, picture->has_tiles ? "false" : "true");
  write_number(out, "seconds", picture->number ? picture->shown_s - picture->step.start_s : (double)NAN);
  write_number(out, "error", picture->error.error.value);
  write_number(out, "noise", picture->error.noise.value);
  write_number(out, "bias", picture->error.bias.value);
  write_text(out, "bias_source", sources[picture->error.bias_source]);
  write_number(out, "stops", picture->stops);
  write_text(out, "channel", picture->channel);
  write_number(out, "least", picture->shown_channel.is_scalar ? picture->shown_channel.least : HUGE_VAL);
  write_number(out, "greatest", picture->shown_channel.is_scalar ? picture->shown_channel.greatest : HUGE_VAL);
  unlock(picture);
  pthread_mutex_lock(&picture->texts_lock);
  write_number(out, "fraction", picture->fraction);
  write_text(out, "stage", picture->stage);
  write_text(out, "message", picture->message);
  pthread_mutex_unlock(&picture->texts_lock);
}

void cli_view_picture_write_pixels(cli_view_picture *picture, FILE *out) {
  lock(picture);
  fwrite(picture->pixels, PIXEL_BYTES, (size_t)picture->width * picture->height, out);
  unlock(picture);
}

void cli_view_picture_write_values(cli_view_picture *picture, unsigned x, unsigned y, FILE *out) {
  lock(picture);
  const neph_image *image = x < picture->width && y < picture->height ? picture->image : NULL;
  const size_t width = image ? neph_image_get_width(image) : 0, height = image ? neph_image_get_height(image) : 0;
  fputc('{', out);
  for (unsigned i = 0; image && i < neph_image_get_channel_count(image); i++) {
    const char *name = neph_image_get_channel_name(image, i);
    const size_t column = x * width / picture->width, row = y * height / picture->height;
    if (i) fputc(',', out);
    cli_put_json_text(out, name);
    const double value = (double)neph_image_get_values(image, name)[row * width + column];
    fprintf(out, isfinite(value) ? ":%.6g" : ":null", value);
  }
  fputc('}', out);
  unlock(picture);
}
