/* SPDX-License-Identifier: Apache-2.0 */
#include "part_forge.h"

#include <stdlib.h>
#include <string.h>

#include "core/hash.h"
#include "parts/part_code.h"
#include "parts/part_grid.h"

/* "nephpart", the format, the header's size and its checksum. */
enum { FORMAT_AT = 8, HEADER_SIZE_AT = 12, SUM_AT = 16, HEADER_AT = 24, SUM_SIZE = 8 };

/* ---- Fields ---- */

typedef struct lister {
  const uint8_t *bytes;
  size_t size, at;
  part_field *out;
  unsigned count;
} lister;

static void add(lister *l, const char *name, size_t size) {
  if (l->count < PART_FIELDS_MAX && l->at + size <= l->size) l->out[l->count++] = (part_field){name, l->at, size};
  l->at += size;
}

static void add_many(lister *l, const char *name, unsigned count, size_t size) {
  for (unsigned i = 0; i < count; i++) add(l, name, size);
}

/* A length, and so many bytes. */
static void add_text(lister *l, const char *name) {
  uint32_t length = 0;
  if (l->at + sizeof length <= l->size) memcpy(&length, l->bytes + l->at, sizeof length);
  add(l, name, sizeof length);
  add(l, name, length);
}

static void add_channels(lister *l) {
  uint32_t count = 0;
  if (l->at + sizeof count <= l->size) memcpy(&count, l->bytes + l->at, sizeof count);
  add(l, "channels: number", 4);
  add(l, "channels: number of sums", 4);
  add(l, "channels: opacity", 4);
  add(l, "channels: first matte", 4);
  add(l, "channels: number of mattes", 4);
  add(l, "channels: scale", 4);
  add(l, "channels: matte identifiers", 4);
  l->at += sizeof(float) * NP_INSTANCES_MAX;
  for (uint32_t c = 0; c < count && l->at < l->size; c++) {
    const unsigned kept = l->count;
    add_text(l, "channels: name");
    add_text(l, "channels: rule");
    add(l, "channels: part", 4);
    add(l, "channels: sum", 4);
    if (c > 0) l->count = kept;
  }
}

static void add_image(lister *l) {
  const size_t start = l->at;
  static const struct {
    const char *name;
    size_t at, size;
  } rows[] = {{"image: camera", offsetof(np_image_header, has_camera), 1},
              {"image: camera of a plane", offsetof(np_image_header, has_ndc), 1},
              {"image: latlong", offsetof(np_image_header, is_latlong), 1},
              {"image: camera", offsetof(np_image_header, world_to_camera), 4},
              {"image: camera of a plane", offsetof(np_image_header, world_to_ndc), 4},
              {"image: chromaticities", offsetof(np_image_header, has_chromaticities), 1},
              {"image: chromaticities", offsetof(np_image_header, chromaticities), 4},
              {"image: display window", offsetof(np_image_header, has_window), 1},
              {"image: data window", offsetof(np_image_header, data_min), 4},
              {"image: data window", offsetof(np_image_header, data_max), 4},
              {"display window", offsetof(np_image_header, display_min), 4},
              {"display window", offsetof(np_image_header, display_max), 4}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    l->at = start + rows[i].at;
    add(l, rows[i].name, rows[i].size);
  }
  l->at = start + sizeof(np_image_header);
}

unsigned part_forge_list(const uint8_t *bytes, size_t size, part_field out[PART_FIELDS_MAX]) {
  lister l = {.bytes = bytes, .size = size, .at = HEADER_SIZE_AT, .out = out};
  add(&l, "header", 4);
  l.at = HEADER_AT;
  add_text(&l, "version");
  add_text(&l, "hash");
  add_many(&l, "window", 4, 4);
  add_many(&l, "whole window", 4, 4);
  add_many(&l, "tile", 2, 4);
  add_many(&l, "samples", 3, 4);
  add(&l, "complete", 4);
  add(&l, "pixel type", 4);
  add(&l, "scatterings", 4);
  add(&l, "target error", 8);
  add_many(&l, "dim", 3, 8);
  add(&l, "lost share", 8);
  add_channels(&l);
  add_image(&l);
  add(&l, "attributes", 4);
  add(&l, "attribute", 4);
  return l.count;
}

/* ---- Checksums ---- */

static void put_sum(uint8_t *at, const void *bytes, size_t size) {
  const uint64_t sum = np_hash_block(bytes, size);
  memcpy(at, &sum, sizeof sum);
}

static void mend_tiles(const np_part_header *h, uint8_t *bytes, size_t size, size_t at) {
  const np_part_grid grid = np_part_grid_make(h);
  const size_t count = np_part_grid_count(&grid), reals = np_part_header_count_reals(h);
  const uint8_t *present = bytes + at;
  if (count > size - at || size - at - count < SUM_SIZE) return;
  put_sum(bytes + at + count, present, count);
  at += count + SUM_SIZE;
  for (size_t tile = 0; tile < count; tile++) {
    size_t pixels;
    if (!present[tile]) continue;
    (void)np_part_grid_get_first(&grid, tile, &pixels);
    const size_t length = pixels * reals * sizeof(double);
    if (length > size - at || size - at - length < SUM_SIZE) return;
    put_sum(bytes + at + length, bytes + at, length);
    at += length + SUM_SIZE;
  }
}

void part_forge_mend(neph_context *context, uint8_t *bytes, size_t size) {
  static const uint32_t format = 1;
  uint32_t header_size;
  if (size < HEADER_AT) return;
  memcpy(bytes, "nephpart", FORMAT_AT);
  memcpy(bytes + FORMAT_AT, &format, sizeof format);
  memcpy(&header_size, bytes + HEADER_SIZE_AT, sizeof header_size);
  if (header_size > size - HEADER_AT) return;
  put_sum(bytes + SUM_AT, bytes + HEADER_AT, header_size);
  np_part_fault fault = {.context = context};
  np_part_header *h = calloc(1, sizeof *h);
  neph_image *image = NULL;
  if (h && np_part_code_decode(context, (char *)bytes + HEADER_AT, header_size, &fault, h, &image))
    mend_tiles(h, bytes, size, HEADER_AT + header_size);
  neph_image_destroy(image);
  np_part_fault_clear(&fault);
  free(h);
}
