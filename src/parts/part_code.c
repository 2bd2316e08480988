/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_code.h"

#include <string.h>

#include "core/alloc.h"
#include "frame/channel_table.h"
#include "parts/part_grid.h"
#include "parts/part_rules.h"

/* A block being written, or being read: one walk over the fields does both. */
typedef struct field_stream {
  neph_context *context;
  np_part_fault *fault; /* reason why a block that is read has failed */
  bool is_reading, has_failed;
  char *bytes;
  size_t size, at; /* `size`: room of a block that is written */
} field_stream;

/* ---- Fields ---- */

/* The fault is noted already, or is that there is no memory. */
static void fail(field_stream *s) {
  s->has_failed = true;
  if (s->is_reading) (void)np_part_fault_set_memory(s->fault);
}

static bool make_room(field_stream *s, const char *name, size_t size) {
  if (!s->has_failed && s->is_reading && s->size - s->at < size) {
    (void)np_part_fault_set(s->fault, "the part's header is cut short in its field '%s': %zu bytes, must have %zu more",
                            name, s->size, size - (s->size - s->at));
    fail(s);
  }
  if (s->has_failed) return false;
  if (s->is_reading || s->size - s->at >= size) return true;
  const size_t larger = 2 * (s->at + size);
  char *bytes = np_alloc_resize(s->context, s->bytes, larger, 1);
  if (!bytes) return !(s->has_failed = true);
  s->bytes = bytes;
  s->size = larger;
  return true;
}

static void pass_bytes(field_stream *s, const char *name, void *field, size_t size) {
  if (!make_room(s, name, size)) return;
  if (s->is_reading)
    memcpy(field, s->bytes + s->at, size);
  else
    memcpy(s->bytes + s->at, field, size);
  s->at += size;
}

#define PASS(stream, name, variable) pass_bytes(stream, name, &(variable), sizeof(variable))

/* A text in a field of `room` bytes. */
static void pass_text(field_stream *s, const char *name, char *text, size_t room) {
  uint32_t length = s->is_reading ? 0 : (uint32_t)strlen(text);
  PASS(s, name, length);
  if (s->has_failed) return;
  if (length >= room) {
    if (s->is_reading)
      (void)np_part_fault_set(s->fault, "its field '%s' has %u bytes, must have less than %zu", name, length, room);
    fail(s);
    return;
  }
  pass_bytes(s, name, text, length);
  if (s->is_reading && !s->has_failed) text[length] = '\0';
}

static void put_text(field_stream *s, const char *text) {
  uint32_t length = (uint32_t)strlen(text);
  PASS(s, "attribute", length);
  if (make_room(s, "attribute", length)) memcpy(s->bytes + s->at, text, length);
  if (!s->has_failed) s->at += length;
}

/* A text, to be freed with np_alloc_free; NULL: failed. */
static char *get_text(field_stream *s) {
  uint32_t length = 0;
  PASS(s, "attribute", length);
  if (!make_room(s, "attribute", length)) return NULL;
  char *text = np_alloc(s->context, (size_t)length + 1, 1);
  if (!text) fail(s);
  if (text) pass_bytes(s, "attribute", text, length);
  return text;
}

/* ---- Channels ---- */

static void pass_channel(field_stream *s, np_channel *channel) {
  char rule[24] = "";
  if (!s->is_reading && channel->kind.finish)
    (void)strncpy(rule, np_channel_finish_get_name(channel->kind.finish), sizeof rule - 1);
  pass_text(s, "channels: name", channel->name, sizeof channel->name);
  pass_text(s, "channels: rule", rule, sizeof rule);
  PASS(s, "channels: part", channel->part);
  PASS(s, "channels: sum", channel->index);
  if (!s->is_reading || s->has_failed) return;
  channel->kind.finish = np_channel_finish_get(rule);
  if (channel->kind.finish) return;
  (void)np_part_fault_set(s->fault, "its field 'channels: rule' of %s is \"%s\", must be a rule of nephos %s",
                          channel->name, rule, neph_version_get_text());
  fail(s);
}

/* Encodes or decodes the channels. Sums without a name follow the picture's channels, and have no finishing rule. */
static void pass_channels(field_stream *s, np_channels *c) {
  PASS(s, "channels: number", c->count);
  PASS(s, "channels: number of sums", c->sum_count);
  PASS(s, "channels: opacity", c->opaque);
  PASS(s, "channels: first matte", c->mattes);
  PASS(s, "channels: number of mattes", c->matte_count);
  PASS(s, "channels: scale", c->scale);
  PASS(s, "channels: matte identifiers", c->matte_ids);
  if (s->is_reading && !s->has_failed && !np_part_rules_check_sums(c, s->fault)) fail(s);
  for (unsigned i = 0; !s->has_failed && i < c->count; i++) pass_channel(s, &c->channel[i]);
}

/* ---- Attributes ---- */

static void put_attributes(field_stream *s, const neph_image *image) {
  uint32_t count = image->attribute_count;
  np_image_header header = image->header;
  PASS(s, "image", header);
  PASS(s, "attributes", count);
  for (unsigned a = 0; a < count; a++) {
    np_image_attribute *attribute = &image->attributes[a];
    uint32_t type = attribute->type;
    PASS(s, "attribute", type);
    PASS(s, "attribute", attribute->number);
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
  PASS(s, "attribute", type);
  PASS(s, "attribute", number);
  char *name = get_text(s), *value = name ? get_text(s) : NULL;
  if (!s->has_failed && (!np_part_rules_check_attribute(image, type, number, name, s->fault) ||
                         set_attribute(image, type, number, name, value)))
    fail(s);
  np_alloc_free(s->context, name);
  np_alloc_free(s->context, value);
}

static void get_attributes(field_stream *s, neph_image *image) {
  uint32_t count = 0;
  PASS(s, "attributes", count);
  if (!s->has_failed && !np_part_rules_check_attribute_count(count, s->fault)) fail(s);
  for (uint32_t a = 0; a < count && !s->has_failed; a++) get_attribute(s, image);
}

/* ---- The whole ---- */

static void pass_fields(field_stream *s, np_part_header *h) {
  pass_text(s, "version", h->version, sizeof h->version);
  pass_text(s, "hash", h->hash, sizeof h->hash);
  PASS(s, "window", h->min);
  PASS(s, "window", h->max);
  PASS(s, "whole window", h->whole_min);
  PASS(s, "whole window", h->whole_max);
  PASS(s, "tile", h->tile_index);
  PASS(s, "tile", h->tile_count);
  PASS(s, "samples", h->sample_begin);
  PASS(s, "samples", h->sample_end);
  PASS(s, "samples", h->sample_count);
  PASS(s, "complete", h->is_complete);
  PASS(s, "pixel type", h->pixel_type);
  PASS(s, "scatterings", h->scattering_max);
  PASS(s, "target error", h->target_error);
  PASS(s, "dim", h->dim);
  PASS(s, "lost share", h->lost_share);
  pass_channels(s, &h->channels);
}

neph_result np_part_code_encode(neph_context *context, const np_part_header *header, char **out_bytes,
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

/* Decodes the image header. Booleans are read as bytes, since any value but 0 or 1 is invalid in a bool. */
static bool get_image_header(field_stream *s, np_part_header *h, np_image_header *out) {
  unsigned char bytes[sizeof *out];
  PASS(s, "image", bytes);
  if (s->has_failed || !np_part_rules_check_flags(bytes, s->fault)) return false;
  memcpy(out, bytes, sizeof *out);
  np_part_header_set_display(h, out);
  return np_part_rules_check(h, s->fault) && np_part_rules_check_image(h, out, s->fault);
}

static bool read_image(field_stream *s, np_part_header *h, neph_image **out_image) {
  np_image_header header;
  const char *names[NP_CHANNELS_MAX];
  if (!get_image_header(s, h, &header)) return false;
  for (unsigned c = 0; c < h->channels.count; c++) names[c] = h->channels.channel[c].name;
  const np_part_grid grid = np_part_grid_make(h);
  if (np_image_create(s->context, grid.width, grid.height, h->channels.count, names, false, out_image))
    return np_part_fault_set_memory(s->fault);
  h->image = *out_image;
  (*out_image)->header = header;
  get_attributes(s, *out_image);
  if (s->has_failed || s->at == s->size) return !s->has_failed;
  return np_part_fault_set(s->fault, "the part's header has %zu bytes behind its attributes, must have none",
                           s->size - s->at);
}

bool np_part_code_decode(neph_context *context, char *bytes, size_t size, np_part_fault *fault,
                         np_part_header *out_header, neph_image **out_image) {
  *out_image = NULL;
  memset(out_header, 0, sizeof *out_header);
  field_stream s = {.context = context, .fault = fault, .is_reading = true, .bytes = bytes, .size = size};
  pass_fields(&s, out_header);
  if (!s.has_failed && read_image(&s, out_header, out_image)) return true;
  neph_image_destroy(*out_image);
  *out_image = NULL;
  return false;
}
