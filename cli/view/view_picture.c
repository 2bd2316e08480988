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
#include "view_past.h"

enum { PIXEL_BYTES = 4, MARKS = 3 };
static const double tile_interval_s = 0.06;

/* When a picture was complete: seconds from its edit, and CPU seconds of the program. */
typedef struct view_mark {
  unsigned long long generation; /* 0: none */
  double seconds, cpu_s;
} view_mark;

struct cli_view_picture {
  neph_context *context;
  pthread_mutex_t lock;
  pthread_mutex_t texts_lock; /* guards stage, message and fraction: messages come while pixels are developed */
  void (*wake)(void *user);
  void *wake_user;
  neph_preview_desc preview;      /* its texts are the picture's own: scenes that lend them come and go */
  neph_image *image;              /* last whole picture; NULL before the first */
  char *image_key;                /* key to keep it under; NULL: it is not kept */
  cli_view_step image_step;       /* its step */
  cli_view_past past;             /* whole pictures before it */
  neph_image *patch;              /* complete picture of a region that lies over it; NULL: none */
  unsigned patch_min[2];          /* its first pixel */
  char *channel;                  /* channel that is shown; NULL: the picture itself */
  cli_view_channel shown_channel; /* range of its colours; its image is NULL between developments */
  double stops;                   /* exposure of the pixels; tiles are developed by that of the picture before them */
  uint8_t *pixels;
  unsigned width, height;
  unsigned long long number, preview_number;
  cli_view_step step;
  double shown_s, tiles_s; /* times of the last change and of the last tile on the page */
  view_mark marks[MARKS];  /* last pictures of the levels 0 and 1, and of those above */
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

static void clear_images(cli_view_picture *picture) {
  neph_image_destroy(picture->image);
  neph_image_destroy(picture->patch);
  free(picture->image_key);
  picture->image = picture->patch = NULL;
  picture->image_key = NULL;
}

void cli_view_picture_destroy(cli_view_picture *picture) {
  if (!picture) return;
  pthread_mutex_destroy(&picture->lock);
  pthread_mutex_destroy(&picture->texts_lock);
  clear_images(picture);
  cli_view_past_clear(&picture->past);
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

/* Pixels between two shares of an edge, one at least. */
static void get_range(double begin, double end, unsigned count, unsigned *out_begin, unsigned *out_end) {
  *out_begin = (unsigned)fmin(fmax(floor(begin * count), 0.0), count - 1.0);
  *out_end = (unsigned)fmin(fmax(ceil(end * count), *out_begin + 1.0), count);
}

static bool has_region(const cli_view_step *step) {
  return step->region[0] < step->region[2] && step->region[1] < step->region[3];
}

void cli_view_step_get_window(const cli_view_step *step, unsigned width, unsigned height, unsigned out_min[2],
                              unsigned out_max[2]) {
  out_min[0] = out_min[1] = 0;
  out_max[0] = width;
  out_max[1] = height;
  if (!step || !has_region(step)) return;
  get_range(step->region[0], step->region[2], width, &out_min[0], &out_max[0]);
  get_range(step->region[1], step->region[3], height, &out_min[1], &out_max[1]);
}

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

/* Develops a picture of the region over the whole. */
static neph_result develop_patch(cli_view_picture *picture, const neph_image *patch, const neph_preview_desc *held) {
  const size_t stride = (size_t)picture->width * PIXEL_BYTES;
  const unsigned width = neph_image_get_width(patch), height = neph_image_get_height(patch);
  uint8_t *first = picture->pixels + picture->patch_min[1] * stride + (size_t)picture->patch_min[0] * PIXEL_BYTES;
  return neph_image_develop(patch, held, 0, 0, width, height, first, stride);
}

/* Develops the chosen channel: colours with the exposure of the picture, single numbers without exposure. Colours of
 * numbers are those of the region, where there is one. */
static neph_result develop_channel(cli_view_picture *picture, neph_preview_desc held) {
  cli_view_channel *shown = &picture->shown_channel, whole = {0};
  const neph_image *finest = picture->patch ? picture->patch : picture->image;
  neph_result result = cli_view_channel_create(picture->context, finest, picture->channel, NULL, shown);
  if (result) return result;
  if (shown->is_scalar) held.view = NEPH_VIEW_RAW, held.exposure_ev = 0.0;
  if (picture->patch)
    result = cli_view_channel_create(picture->context, picture->image, picture->channel, shown, &whole);
  if (!result) result = develop_image(picture, whole.image ? whole.image : shown->image, &held);
  if (!result && picture->patch) result = develop_patch(picture, shown->image, &held);
  neph_image_destroy(whole.image);
  neph_image_destroy(shown->image);
  shown->image = NULL;
  return result;
}

/* Develops the last complete picture. */
static neph_result develop(cli_view_picture *picture) {
  neph_result result = neph_image_compute_exposure(picture->image, &picture->preview, &picture->stops);
  if (result) return result;
  const neph_preview_desc held = get_held_preview(picture);
  picture->shown_channel = (cli_view_channel){0};
  if (picture->channel && (result = develop_channel(picture, held)) != NEPH_ERROR_NOT_FOUND) return result;
  result = develop_image(picture, picture->image, &held);
  return result || !picture->patch ? result : develop_patch(picture, picture->patch, &held);
}

static void note_change(cli_view_picture *picture, const cli_view_step *step) {
  picture->step = *step;
  picture->shown_s = cli_view_clock_get_s();
  picture->number++;
}

/* Puts the whole picture among those of the past, unless `key` is its own: a better one replaces it. */
static void keep_image(cli_view_picture *picture, const char *key) {
  if (!picture->image || !picture->image_key || (key && !strcmp(key, picture->image_key))) return;
  cli_view_past_put(&picture->past, picture->image_key, &picture->image_step, picture->image);
  picture->image = NULL;
  picture->image_key = NULL;
}

/* Takes an image, as the whole or as the region over it. */
static void lay_image(cli_view_picture *picture, const cli_view_step *step, const char *key, neph_image *image) {
  const bool is_patch = step->level && has_region(step) && picture->image;
  if (!is_patch) {
    keep_image(picture, key);
    clear_images(picture);
    picture->image = image;
    picture->image_key = key ? strdup(key) : NULL;
    picture->image_step = *step;
    return;
  }
  unsigned max[2];
  cli_view_step_get_window(step, step->width, step->height, picture->patch_min, max);
  neph_image_destroy(picture->patch);
  picture->patch = image;
}

/* Notes when the pictures of the first levels were complete; one of more samples stands for those that were left out.
 */
static void mark_levels(cli_view_picture *picture, const cli_view_step *step) {
  for (unsigned i = 0; i < MARKS && i <= step->level; i++)
    if (i == step->level || picture->marks[i].generation != step->generation)
      picture->marks[i] = (view_mark){step->generation, picture->shown_s - step->start_s, cli_view_clock_get_cpu_s()};
}

/* Shows a picture: the caller has locked. */
static neph_result show(cli_view_picture *picture, const cli_view_step *step, const char *key, neph_image *image) {
  lay_image(picture, step, key, image);
  picture->has_tiles = false;
  picture->error = (neph_image_error)NEPH_IMAGE_ERROR_DEFAULT;
  neph_result result = neph_image_get_error(image, &picture->error);
  if (!result) result = resize(picture, step->width, step->height);
  if (!result) result = develop(picture);
  if (!result) note_change(picture, step);
  if (!result) mark_levels(picture, step);
  if (result) clear_images(picture); /* without colours, say: nothing can be shown until the next picture */
  return result;
}

neph_result cli_view_picture_show(cli_view_picture *picture, const cli_view_step *step, const char *key,
                                  neph_image *image) {
  lock(picture);
  const neph_result result = show(picture, step, key, image);
  unlock(picture);
  picture->wake(picture->wake_user);
  return result;
}

/* Takes the picture of a key from the page or from the past; NULL: there is none. */
static neph_image *take_image(cli_view_picture *picture, const char *key, cli_view_step *out_step) {
  if (!picture->image_key || strcmp(key, picture->image_key)) return cli_view_past_take(&picture->past, key, out_step);
  neph_image *image = picture->image;
  *out_step = picture->image_step;
  picture->image = NULL;
  return image;
}

bool cli_view_picture_recall(cli_view_picture *picture, const char *key, cli_view_step *step,
                             neph_image_error *out_error) {
  cli_view_step kept;
  lock(picture);
  neph_image *image = take_image(picture, key, &kept);
  if (image) {
    kept.generation = step->generation;
    kept.start_s = step->start_s;
    kept.waited_s = cli_view_clock_get_s() - step->start_s;
  }
  const bool is_shown = image && !show(picture, &kept, key, image);
  if (is_shown) *out_error = picture->error;
  unlock(picture);
  if (is_shown) *step = kept;
  if (is_shown) picture->wake(picture->wake_user);
  return is_shown;
}

/* Develops a tile to its place in the picture. */
static neph_result develop_tile(const cli_view_picture *picture, const cli_view_step *step, const neph_tile *tile) {
  neph_preview_desc held = get_held_preview(picture);
  unsigned min[2], max[2];
  held.glare = 0.0; /* light of the whole picture, which is developed when it is complete */
  cli_view_step_get_window(step, picture->width, picture->height, min, max);
  const size_t stride = (size_t)picture->width * PIXEL_BYTES;
  uint8_t *first = picture->pixels + (min[1] + tile->min[1]) * stride + (size_t)(min[0] + tile->min[0]) * PIXEL_BYTES;
  return neph_image_develop(tile->image, &held, tile->min[0], tile->min[1], tile->max[0], tile->max[1], first, stride);
}

neph_result cli_view_picture_show_tile(cli_view_picture *picture, const cli_view_step *step, const neph_tile *tile) {
  lock(picture);
  const bool fits = !picture->channel && picture->width == step->width && picture->height == step->height;
  const neph_result result = fits ? develop_tile(picture, step, tile) : NEPH_OK;
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

void cli_view_picture_set_preview(cli_view_picture *picture, const neph_preview_desc *preview) {
  lock(picture);
  neph_result result = copy_preview(&picture->preview, preview);
  picture->preview_number++;
  if (picture->image && !result) result = develop(picture);
  if (picture->image && !result) picture->number++;
  unlock(picture);
  picture->wake(picture->wake_user);
}

neph_result cli_view_picture_save(cli_view_picture *picture, const char *path, bool is_exr) {
  lock(picture);
  neph_result result = NEPH_ERROR_NOT_FOUND;
  const neph_image *image = picture->patch ? picture->patch : picture->image;
  const neph_preview_desc held = get_held_preview(picture);
  if (image && is_exr) result = neph_image_save_exr(image, path, NEPH_PIXEL_HALF);
  if (image && !is_exr) result = neph_image_save_png(image, path, picture->patch ? &held : &picture->preview);
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
  write_number(out, "waited", picture->step.waited_s);
  fputs(",\"marks\":[", out);
  for (size_t i = 0; i < MARKS; i++)
    fprintf(out, "%s[%llu,%.6g,%.6g]", i ? "," : "", picture->marks[i].generation, picture->marks[i].seconds,
            picture->marks[i].cpu_s);
  fputc(']', out);
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

/* Pixel of an image that lies behind a pixel of the page; the image of the last whole picture may be smaller. */
static const neph_image *get_behind(const cli_view_picture *picture, unsigned x, unsigned y, size_t *out_index) {
  const neph_image *image = x < picture->width && y < picture->height ? picture->image : NULL;
  const unsigned *min = picture->patch_min;
  if (image && picture->patch && x >= min[0] && y >= min[1] && x - min[0] < neph_image_get_width(picture->patch) &&
      y - min[1] < neph_image_get_height(picture->patch)) {
    *out_index = (size_t)(y - min[1]) * neph_image_get_width(picture->patch) + (x - min[0]);
    return picture->patch;
  }
  const size_t width = image ? neph_image_get_width(image) : 0, height = image ? neph_image_get_height(image) : 0;
  if (image) *out_index = y * height / picture->height * width + x * width / picture->width;
  return image;
}

void cli_view_picture_write_values(cli_view_picture *picture, unsigned x, unsigned y, FILE *out) {
  size_t index = 0;
  lock(picture);
  const neph_image *image = get_behind(picture, x, y, &index);
  fputc('{', out);
  for (unsigned i = 0; image && i < neph_image_get_channel_count(image); i++) {
    const char *name = neph_image_get_channel_name(image, i);
    if (i) fputc(',', out);
    cli_put_json_text(out, name);
    const double value = (double)neph_image_get_values(image, name)[index];
    fprintf(out, isfinite(value) ? ":%.6g" : ":null", value);
  }
  fputc('}', out);
  unlock(picture);
}
