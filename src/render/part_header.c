/* SPDX-License-Identifier: Apache-2.0 */
#include "render/part_header.h"

#include <string.h>

#include "core/alloc.h"
#include "render/channel_table.h"

/* A block being written, or being read: one walk over the fields does both. */
typedef struct field_stream {
  neph_context *context;
  bool is_reading, has_failed;
  char *bytes;
  size_t size, at; /* of a block that is written, `size` is its room */
} field_stream;

/* ---- Fields ---- */

static bool make_room(field_stream *s, size_t size) {
  if (s->has_failed || (s->is_reading && s->size - s->at < size)) return !(s->has_failed = true);
  if (s->is_reading || s->size - s->at >= size) return true;
  const size_t larger = 2 * (s->at + size);
  char *bytes = np_alloc_resize(s->context, s->bytes, larger, 1);
  if (!bytes) return !(s->has_failed = true);
  s->bytes = bytes;
  s->size = larger;
  return true;
}

static void pass_bytes(field_stream *s, void *field, size_t size) {
  if (!make_room(s, size)) return;
  if (s->is_reading)
    memcpy(field, s->bytes + s->at, size);
  else
    memcpy(s->bytes + s->at, field, size);
  s->at += size;
}

#define PASS(stream, variable) pass_bytes(stream, &(variable), sizeof(variable))

/* A text in a field of `room` bytes. */
static void pass_text(field_stream *s, char *text, size_t room) {
  uint32_t length = s->is_reading ? 0 : (uint32_t)strlen(text);
  PASS(s, length);
  if (length >= room) s->has_failed = true;
  if (!s->has_failed) pass_bytes(s, text, length);
  if (s->is_reading && !s->has_failed) text[length] = '\0';
}

static void put_text(field_stream *s, const char *text) {
  uint32_t length = (uint32_t)strlen(text);
  PASS(s, length);
  if (make_room(s, length)) memcpy(s->bytes + s->at, text, length);
  if (!s->has_failed) s->at += length;
}

/* A text, to be freed with np_alloc_free; NULL: failed. */
static char *get_text(field_stream *s) {
  uint32_t length = 0;
  PASS(s, length);
  if (!make_room(s, length)) return NULL;
  char *text = np_alloc(s->context, (size_t)length + 1, 1);
  if (!text) s->has_failed = true;
  if (text) pass_bytes(s, text, length);
  return text;
}

/* ---- Channels ---- */

static void pass_channel(field_stream *s, np_channel *channel) {
  char rule[24] = "";
  if (!s->is_reading && channel->kind.finish)
    (void)strncpy(rule, np_channel_finish_get_name(channel->kind.finish), sizeof rule - 1);
  pass_text(s, channel->name, sizeof channel->name);
  pass_text(s, rule, sizeof rule);
  PASS(s, channel->part);
  PASS(s, channel->index);
  if (!s->is_reading || !*rule) return;
  channel->kind.finish = np_channel_finish_get(rule);
  if (!channel->kind.finish) s->has_failed = true;
}

/* Sums without a name come after the picture's channels, and no pixel is finished by their rules. */
static void pass_channels(field_stream *s, np_channels *c) {
  PASS(s, c->count);
  PASS(s, c->sum_count);
  PASS(s, c->opaque);
  PASS(s, c->mattes);
  PASS(s, c->matte_count);
  PASS(s, c->scale);
  PASS(s, c->matte_ids);
  const bool is_sound = c->count <= c->sum_count && c->sum_count <= NP_CHANNELS_MAX && c->count > 0 &&
                        c->matte_count <= NP_INSTANCES_MAX + 1 && c->mattes + c->matte_count <= c->sum_count &&
                        (c->opaque < c->sum_count || c->opaque == NP_CHANNEL_NONE);
  if (!is_sound) s->has_failed = true;
  for (unsigned i = 0; !s->has_failed && i < c->count; i++) {
    pass_channel(s, &c->channel[i]);
    if (!s->has_failed && (!c->channel[i].kind.finish || c->channel[i].index >= c->sum_count)) s->has_failed = true;
  }
}

/* ---- Attributes ---- */

static void put_attributes(field_stream *s, const neph_image *image) {
  uint32_t count = image->attribute_count;
  np_image_header header = image->header;
  PASS(s, header);
  PASS(s, count);
  for (unsigned a = 0; a < count; a++) {
    np_image_attribute *attribute = &image->attributes[a];
    uint32_t type = attribute->type;
    PASS(s, type);
    PASS(s, attribute->number);
    put_text(s, attribute->name);
    put_text(s, attribute->value);
  }
}

static neph_result set_attribute(neph_image *image, uint32_t type, double number, const char *name, const char *value) {
  if (type == NP_IMAGE_INTEGER) return np_image_set_integer(image, name, (int32_t)number);
  if (type == NP_IMAGE_REAL) return np_image_set_real(image, name, number);
  return neph_image_set_attribute(image, name, value);
}

static void get_attribute(field_stream *s, neph_image *image) {
  uint32_t type = 0;
  double number = 0.0;
  PASS(s, type);
  PASS(s, number);
  char *name = get_text(s), *value = name ? get_text(s) : NULL;
  if (!s->has_failed && set_attribute(image, type, number, name, value)) s->has_failed = true;
  np_alloc_free(s->context, name);
  np_alloc_free(s->context, value);
}

static void get_attributes(field_stream *s, neph_image *image) {
  uint32_t count = 0;
  PASS(s, image->header);
  PASS(s, count);
  for (uint32_t a = 0; a < count && !s->has_failed; a++) get_attribute(s, image);
}

/* ---- The whole ---- */

static void pass_fields(field_stream *s, np_part_header *h) {
  pass_text(s, h->version, sizeof h->version);
  pass_text(s, h->hash, sizeof h->hash);
  PASS(s, h->min);
  PASS(s, h->max);
  PASS(s, h->whole_min);
  PASS(s, h->whole_max);
  PASS(s, h->tile_index);
  PASS(s, h->tile_count);
  PASS(s, h->sample_begin);
  PASS(s, h->sample_end);
  PASS(s, h->sample_count);
  PASS(s, h->is_complete);
  PASS(s, h->pixel_type);
  PASS(s, h->scattering_max);
  PASS(s, h->target_error);
  PASS(s, h->dim);
  PASS(s, h->lost_share);
  pass_channels(s, &h->channels);
}

/* Whether a window is one, and lies in the other. */
static bool is_window(const np_part_header *h) {
  bool is_sound = true;
  for (int k = 0; k < 2; k++)
    is_sound = is_sound && h->whole_min[k] > -NP_IMAGE_SIDE_MAX && h->whole_max[k] < 2 * NP_IMAGE_SIDE_MAX &&
               h->min[k] < h->max[k] && h->min[k] >= h->whole_min[k] && h->max[k] <= h->whole_max[k];
  return is_sound;
}

static bool is_range(const np_part_header *h) {
  return h->sample_begin < h->sample_end && h->sample_end <= h->sample_count &&
         h->sample_begin % NP_FILM_LEAF_SAMPLES == 0 && h->tile_index < h->tile_count;
}

unsigned np_part_header_count_reals(const np_part_header *header) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned sets = header->is_complete ? 1 : np_film_list_nodes(header->sample_begin, header->sample_end, nodes);
  return NP_PART_RECORD_NUMBERS + sets * np_channels_count_numbers(&header->channels);
}

void np_part_record_begin(const np_part_header *header, np_film_accumulator *accumulator) {
  np_film_accumulator_begin_moments(accumulator, header->channels.sum_count + NP_PIXEL_SUMS_OWN, NP_BAND_COUNT,
                                    header->sample_begin);
}

bool np_part_record_add(const np_part_header *header, const double *record, np_film_accumulator *accumulator) {
  np_film_node nodes[NP_FILM_NODES_MAX];
  const unsigned count = np_film_list_nodes(header->sample_begin, header->sample_end, nodes);
  const double *numbers = record + NP_PART_RECORD_NUMBERS;
  for (unsigned n = 0; n < count; n++, numbers += np_channels_count_numbers(&header->channels)) {
    nodes[n].sums = numbers;
    if (!np_film_accumulator_add_node(accumulator, &nodes[n])) return false;
  }
  return true;
}

neph_result np_part_header_encode(neph_context *context, const np_part_header *header, char **out_bytes,
                                  size_t *out_size) {
  *out_bytes = NULL;
  np_part_header *copy = np_alloc(context, 1, sizeof *copy); /* the walk takes fields that it might fill */
  if (!copy) return NEPH_ERROR_OUT_OF_MEMORY;
  *copy = *header;
  field_stream s = {.context = context};
  pass_fields(&s, copy);
  put_attributes(&s, header->image);
  np_alloc_free(context, copy);
  if (s.has_failed) return np_alloc_free(context, s.bytes), NEPH_ERROR_OUT_OF_MEMORY;
  *out_bytes = s.bytes;
  *out_size = s.at;
  return NEPH_OK;
}

bool np_part_header_decode(neph_context *context, char *bytes, size_t size, np_part_header *out_header,
                           neph_image **out_image) {
  *out_image = NULL;
  memset(out_header, 0, sizeof *out_header);
  field_stream s = {.context = context, .is_reading = true, .bytes = bytes, .size = size};
  pass_fields(&s, out_header);
  if (s.has_failed || !is_window(out_header) || !is_range(out_header)) return false;
  const char *names[NP_CHANNELS_MAX];
  for (unsigned c = 0; c < out_header->channels.count; c++) names[c] = out_header->channels.channel[c].name;
  const unsigned width = (unsigned)(out_header->max[0] - out_header->min[0]);
  const unsigned height = (unsigned)(out_header->max[1] - out_header->min[1]);
  if (np_image_create(context, width, height, out_header->channels.count, names, false, out_image)) return false;
  get_attributes(&s, *out_image);
  out_header->image = *out_image;
  if (!s.has_failed && s.at == size) return true;
  neph_image_destroy(*out_image);
  *out_image = NULL;
  return false;
}
