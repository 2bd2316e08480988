/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture to the picture: row by row, so that no more than a row of tiles of each part is in memory. */
#include <stdio.h>
#include <string.h>

#include <nephos/parts.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/parallel.h"
#include "frame/render_header.h"
#include "parts/merge_cover.h"
#include "parts/merge_header.h"
#include "parts/merge_part.h"
#include "parts/merge_tile.h"

typedef struct merging {
  neph_context *context;
  np_merge_part *parts;
  size_t count;
  np_frame *frame;       /* described and filled as far as pixels are finished */
  np_assembly *assembly; /* assembly of the frame, of which only the context is set */
  neph_render_desc desc; /* the frame's description */
  np_film_accumulator *film;
  neph_image *image;
} merging;

static neph_result open_parts(merging *m, const char *const *paths, size_t count) {
  m->parts = np_alloc(m->context, count, sizeof *m->parts);
  if (!m->parts) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (; m->count < count && !result; m->count++) {
    result = np_merge_part_open(m->context, paths[m->count], &m->parts[m->count]);
    if (!result) result = np_merge_part_compare(&m->parts[m->count], &m->parts[0]);
  }
  return result ? result : np_merge_cover_check(m->parts, count);
}

/* ---- The picture ---- */

/* The part whose header serves the picture: one with the rules of its channels, if there is any. */
static const np_merge_part *choose_model(const merging *m) {
  for (size_t i = 0; i < m->count; i++)
    if (m->parts[i].file) return &m->parts[i];
  return &m->parts[0];
}

static neph_result create_image(merging *m, const np_merge_part *model) {
  const neph_image *of = model->header.image;
  const char **names = np_alloc(m->context, of->channel_count, sizeof *names);
  if (!names) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned c = 0; c < of->channel_count; c++) names[c] = of->channels[c].name;
  neph_result result = neph_image_create(
      m->context, (unsigned)(model->header.whole_max[0] - model->header.whole_min[0]),
      (unsigned)(model->header.whole_max[1] - model->header.whole_min[1]), of->channel_count, names, &m->image);
  np_alloc_free(m->context, names);
  return result ? result : np_merge_header_write(m->parts, m->count, model, m->image);
}

static neph_result create_frame(merging *m, const np_merge_part *model) {
  np_frame *f = m->frame = np_alloc(m->context, 1, sizeof *f);
  m->assembly = np_alloc(m->context, 1, sizeof *m->assembly);
  m->film = np_alloc(m->context, 1, sizeof *m->film);
  if (!f || !m->assembly || !m->film) return NEPH_ERROR_OUT_OF_MEMORY;
  m->assembly->context = m->context;
  const bool has_error = neph_image_get_attribute(model->header.image, "nephos:pixelError");
  m->desc = (neph_render_desc)NEPH_RENDER_DESC_DEFAULT;
  m->desc.sample_count = has_error ? 2 : 1;
  f->assembly = m->assembly;
  f->desc = &m->desc;
  f->width = m->image->width;
  f->height = m->image->height;
  memcpy(f->min, model->header.whole_min, sizeof f->min);
  f->totals = np_alloc(m->context, np_frame_count_tiles(f), sizeof *f->totals);
  if (!f->totals || !model->file) return f->totals ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  const np_part_header *h = np_part_file_get_header(model->file);
  m->desc.sample_count = h->sample_count;
  m->desc.target_error = h->target_error;
  m->desc.scattering_max = h->scattering_max;
  f->settings.lost_share = (float)h->lost_share;
  f->channels = h->channels;
  memcpy(f->dim, h->dim, sizeof f->dim);
  for (unsigned c = 0; c < f->channels.count; c++)
    f->planes[c] = neph_image_get_channel(m->image, f->channels.channel[c].name);
  return NEPH_OK;
}

/* ---- Pixels of tiles ---- */

static void copy_row(const merging *m, const np_merge_part *part, int y) {
  for (unsigned c = 0; c < m->image->channel_count; c++) {
    const float *from = neph_image_get_values(part->tile, m->image->channels[c].name);
    float *to = m->image->channels[c].values + (size_t)(y - m->frame->min[1]) * m->image->width;
    memcpy(to, from + (size_t)(y - part->header.min[1]) * part->tile->width, part->tile->width * sizeof *to);
  }
}

/* ---- Pixels of parts ---- */

/* The parts have all the samples of the pixel, in their order. */
static void finish_pixel(const merging *m, int x, int y) {
  const np_frame *f = m->frame;
  double numbers[NP_PIXEL_NUMBERS_MAX];
  np_pixel_facts facts = {.distance = 0.0};
  uint32_t count = 0;
  bool is_whole = false;
  for (size_t i = 0; i < m->count; i++) {
    const np_merge_part *part = &m->parts[i];
    if (y < part->header.min[1] || y >= part->header.max[1]) continue;
    const np_part_header *h = np_part_file_get_header(part->file);
    const double *record = np_merge_part_get_record(part, x, y);
    if (count == 0) np_part_record_begin(h, m->film);
    count += (uint32_t)record[NP_PART_RECORD_COUNT];
    facts.distance = record[NP_PART_RECORD_DISTANCE];
    facts.depth = record[NP_PART_RECORD_DEPTH];
    is_whole = h->is_complete;
    if (is_whole)
      memcpy(numbers, record + NP_PART_RECORD_NUMBERS, np_channels_count_numbers(&f->channels) * sizeof *numbers);
    else
      (void)np_part_record_add(h, record, m->film);
  }
  if (!is_whole) np_film_accumulator_finish(m->film, numbers);
  facts.spread = np_channels_get_spread(&f->channels, numbers, count);
  const unsigned column = (unsigned)(x - f->min[0]), row = (unsigned)(y - f->min[1]);
  const size_t across = (f->width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  np_tile_total *total = &f->totals[row / NP_TILE_EDGE * across + column / NP_TILE_EDGE];
  np_frame_develop_pixel(f, (size_t)row * f->width + column, &facts, numbers, total);
}

static neph_result merge_row(merging *m, int y) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < m->count && !result; i++) {
    np_merge_part *part = &m->parts[i];
    if (y < part->header.min[1] || y >= part->header.max[1]) continue;
    if (part->tile) return copy_row(m, part, y), NEPH_OK;
    result = np_merge_part_load_row(part, y);
  }
  for (unsigned column = 0; column < m->frame->width && !result; column++)
    finish_pixel(m, m->frame->min[0] + (int)column, y);
  return result;
}

static neph_result merge(merging *m) {
  const np_merge_part *model = choose_model(m);
  neph_result result = create_image(m, model);
  if (!result) result = create_frame(m, model);
  for (int y = model->header.whole_min[1]; y < model->header.whole_max[1] && !result; y++) result = merge_row(m, y);
  for (size_t i = 0; i < m->count && !result; i++)
    if (m->parts[i].tile) np_merge_tile_add_totals(&m->parts[i], &m->frame->totals[0]);
  return result ? result : np_frame_describe(m->frame, m->image);
}

static neph_pixel_type get_pixel_type(const np_merge_part *part) {
  if (part->file) return (neph_pixel_type)np_part_file_get_header(part->file)->pixel_type;
  for (unsigned c = 0; c < part->tile->channel_count; c++)
    if (part->tile->channels[c].stored && !strcmp(part->tile->channels[c].stored, "half")) return NEPH_PIXEL_HALF;
  return NEPH_PIXEL_FLOAT;
}

static void clear(merging *m) {
  for (size_t i = 0; i < m->count; i++) np_merge_part_close(&m->parts[i]);
  if (m->frame) np_alloc_free(m->context, m->frame->totals);
  np_alloc_free(m->context, m->frame);
  np_alloc_free(m->context, m->assembly);
  np_alloc_free(m->context, m->film);
  np_alloc_free(m->context, m->parts);
}

neph_result neph_parts_merge(neph_context *context, const char *const *paths, size_t path_count,
                             neph_pixel_type *out_pixel_type, neph_image **out_image) {
  if (NP_LACKS_OUT(context, out_image, paths)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_image = NULL;
  if (path_count == 0) return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "no parts are given: must be one or more");
  merging m = {.context = context};
  const unsigned mode = np_float_mode_enter(); /* the mode in which the samples were taken */
  neph_result result = open_parts(&m, paths, path_count);
  if (!result) result = merge(&m);
  np_float_mode_leave(mode);
  if (!result && out_pixel_type) *out_pixel_type = get_pixel_type(choose_model(&m));
  clear(&m);
  if (result)
    neph_image_destroy(m.image);
  else
    *out_image = m.image;
  return result;
}
