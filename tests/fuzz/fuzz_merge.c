/* SPDX-License-Identifier: Apache-2.0 */
/* Merges several parts of one picture.
 *
 * An input is a row of pieces, each a byte for its kind and two for its length. A piece of an even kind is the file of
 * a part, whose checksums are corrected. One of an odd kind describes a tile: first column and row, and last ones of
 * the display window, four integers of 32 bits, width and height in a byte each, and then attributes, NAME=VALUE in a
 * line each. It is written as an .exr, so that the merge is tested and not the reader of OpenEXR. */
#include "fuzz_support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <nephos/parts.h>

#include "../part_forge.h"
#include "image/image_private.h"

enum { PIECES_MAX = 6, HEAD = 3, TILE_HEAD = 18, SIDE_MAX = 24, PATH_SIZE = 96 };

typedef struct pieces {
  char path[PIECES_MAX][PATH_SIZE];
  unsigned count;
} pieces;

/* ---- Parts ---- */

static void write_file(const char *path, const uint8_t *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) abort();
}

static void write_part(const char *path, const uint8_t *data, size_t size) {
  uint8_t *bytes = malloc(size + 1);
  if (!bytes) abort();
  memcpy(bytes, data, size);
  part_forge_mend(fuzz_get_context(), bytes, size);
  write_file(path, bytes, size);
  free(bytes);
}

/* ---- Tiles ---- */

/* Numbers as such, since readers of OpenEXR take them so. */
static void set_attribute(neph_image *image, char *line) {
  char *value = strchr(line, '='), *end;
  if (!value || value == line || value - line > NP_IMAGE_NAME_MAX) return;
  *value++ = '\0';
  const double number = strtod(value, &end);
  const bool is_number = end > value && !*end;
  if (is_number ? np_image_set_real(image, line, number) : neph_image_set_attribute(image, line, value)) abort();
}

static void set_attributes(neph_image *image, const uint8_t *text, size_t size) {
  char *copy = malloc(size + 1);
  if (!copy) abort();
  memcpy(copy, text, size);
  copy[size] = '\0';
  for (char *line = strtok(copy, "\n"); line; line = strtok(NULL, "\n")) set_attribute(image, line);
  free(copy);
}

static void set_windows(neph_image *image, const int32_t place[4]) {
  np_image_header *h = &image->header;
  const unsigned size[2] = {image->width, image->height};
  h->has_window = true;
  for (int k = 0; k < 2; k++) {
    h->data_min[k] = place[k] % (1 << 20);
    h->data_max[k] = h->data_min[k] + (int)size[k] - 1;
    h->display_max[k] = abs(place[2 + k] % (1 << 20));
  }
}

/* False: the piece describes no tile that an .exr can hold. */
static bool write_tile(const char *path, const uint8_t *data, size_t size) {
  static const char *const channels[] = {"R", "G", "B", "A", "Z"};
  int32_t place[4];
  neph_image *image = NULL;
  if (size < TILE_HEAD) return false;
  memcpy(place, data, sizeof place);
  const unsigned width = 1 + data[16] % SIDE_MAX, height = 1 + data[17] % SIDE_MAX;
  if (neph_image_create(fuzz_get_context(), width, height, 5, channels, &image)) abort();
  set_windows(image, place);
  set_attributes(image, data + TILE_HEAD, size - TILE_HEAD);
  const neph_result result = neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT);
  fuzz_expect(result);
  neph_image_destroy(image);
  return result == NEPH_OK;
}

/* ---- The merge ---- */

static void write_pieces(pieces *p, const char *folder, const uint8_t *data, size_t size) {
  while (size > HEAD && p->count < PIECES_MAX) {
    const size_t length = (size_t)data[1] | (size_t)data[2] << 8, own = length < size - HEAD ? length : size - HEAD;
    char *path = p->path[p->count];
    snprintf(path, PATH_SIZE, "%.*s%u.%s", (int)(strrchr(folder, '/') + 1 - folder), folder, p->count,
             data[0] & 1 ? "exr" : "npart");
    if (data[0] & 1 && !write_tile(path, data + HEAD, own)) return;
    if (!(data[0] & 1)) write_part(path, data + HEAD, own);
    p->count++;
    data += HEAD + own;
    size -= HEAD + own;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static pieces p;
  const char *paths[PIECES_MAX];
  neph_image *image = NULL;
  p.count = 0;
  write_pieces(&p, fuzz_write_file("none", data, 0), data, size);
  for (unsigned i = 0; i < p.count; i++) paths[i] = p.path[i];
  if (p.count) fuzz_expect(neph_parts_merge(fuzz_get_context(), paths, p.count, NULL, &image));
  neph_image_destroy(image);
  for (unsigned i = 0; i < p.count; i++) unlink(paths[i]);
  return 0;
}
