/* SPDX-License-Identifier: Apache-2.0 */
#include "view_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "print.h"

enum { EDGE = CLI_VIEW_MAP_EDGE, ROW_BYTES = 1 + 2 * EDGE, DATA_BYTES = ROW_BYTES * EDGE, BLOCK_BYTES = 65535 };

void cli_view_map_clear(cli_view_map *map) {
  free(map->path);
  *map = (cli_view_map){0};
}

static double limit(double value) { return value > 0.0 ? fmin(value, 1.0) : 0.0; }

void cli_view_map_fill(cli_view_map *map, double coverage) {
  for (size_t i = 0; i < (size_t)EDGE * EDGE; i++) map->at[i] = (float)limit(coverage);
  memcpy(map->before, map->at, sizeof map->at);
  map->stroke = 0;
}

neph_result cli_view_map_load(cli_view_map *map, neph_context *context, const char *path) {
  neph_image *image = NULL;
  neph_result result = neph_image_load_png(context, path, &image);
  if (result) return result;
  const float *plane = neph_image_get_values(image, neph_image_get_channel_name(image, 0));
  const size_t width = neph_image_get_width(image), height = neph_image_get_height(image);
  cli_view_map_fill(map, 0.0);
  for (size_t y = 0; y < EDGE; y++)
    for (size_t x = 0; x < EDGE; x++)
      map->at[y * EDGE + x] = (float)limit((double)plane[y * height / EDGE * width + x * width / EDGE]);
  memcpy(map->before, map->at, sizeof map->at);
  neph_image_destroy(image);
  return NEPH_OK;
}

/* ---- Brush ---- */

void cli_view_map_paint(cli_view_map *map, const cli_view_dab *dab, unsigned long long stroke) {
  if (!stroke || stroke != map->stroke) memcpy(map->before, map->at, sizeof map->at);
  map->stroke = stroke;
  const double radius = fmax(limit(dab->radius) * EDGE, 0.5), strength = limit(dab->strength);
  for (int y = 0; y < EDGE; y++)
    for (int x = 0; x < EDGE; x++) {
      const double away = hypot(x + 0.5 - dab->x * EDGE, y + 0.5 - dab->y * EDGE) / radius;
      float *at = &map->at[y * EDGE + x];
      if (!(away < 1.0)) continue;
      const double share = strength * (1.0 - away * away) * (1.0 - away * away); /* smooth at its edge */
      *at = (float)limit((double)*at + share * (limit(dab->coverage) - (double)*at));
    }
}

void cli_view_map_swap(cli_view_map *map) {
  for (size_t i = 0; i < (size_t)EDGE * EDGE; i++) {
    const float now = map->at[i];
    map->at[i] = map->before[i];
    map->before[i] = now;
  }
}

void cli_view_map_write_pixels(const cli_view_map *map, FILE *out) {
  for (size_t i = 0; i < (size_t)EDGE * EDGE; i++) fputc((int)lrint(255.0 * (double)map->at[i]), out);
}

/* ---- PNG (ISO/IEC 15948), its data stored without compression ---- */

static void put_word(unsigned char *to, uint32_t word) {
  for (int k = 0; k < 4; k++) to[k] = (unsigned char)(word >> (24 - 8 * k));
}

static uint32_t add_crc(uint32_t crc, const unsigned char *bytes, size_t count) {
  for (size_t i = 0; i < count; i++) {
    crc ^= bytes[i];
    for (int k = 0; k < 8; k++) crc = crc & 1u ? 0xedb88320u ^ crc >> 1 : crc >> 1;
  }
  return crc;
}

/* A chunk is its length, its kind, its bytes, and the CRC of both. */
static void write_chunk(FILE *out, const char *kind, const unsigned char *bytes, size_t count) {
  unsigned char head[8], tail[4];
  put_word(head, (uint32_t)count);
  memcpy(head + 4, kind, 4);
  put_word(tail, ~add_crc(add_crc(UINT32_MAX, head + 4, 4), bytes, count));
  fwrite(head, 1, sizeof head, out);
  fwrite(bytes, 1, count, out);
  fwrite(tail, 1, sizeof tail, out);
}

/* Rows of big-endian samples, each behind a byte that says it is not filtered. */
static void fill_rows(const cli_view_map *map, unsigned char *rows) {
  for (size_t y = 0; y < EDGE; y++)
    for (size_t x = 0; x < EDGE; x++) {
      const unsigned value = (unsigned)lrint(65535.0 * (double)map->at[y * EDGE + x]);
      unsigned char *to = rows + y * ROW_BYTES + 1 + 2 * x;
      to[0] = (unsigned char)(value >> 8);
      to[1] = (unsigned char)value;
    }
}

/* Wraps bytes as a zlib stream of stored blocks; returns its size. */
static size_t store(const unsigned char *bytes, size_t count, unsigned char *out) {
  size_t size = 2;
  uint32_t a = 1, b = 0; /* Adler-32 */
  out[0] = 0x78, out[1] = 0x01;
  for (size_t at = 0; at < count; at += BLOCK_BYTES) {
    const size_t length = count - at < BLOCK_BYTES ? count - at : BLOCK_BYTES;
    out[size++] = at + length == count;
    out[size++] = (unsigned char)length, out[size++] = (unsigned char)(length >> 8);
    out[size++] = (unsigned char)~length, out[size++] = (unsigned char)(~length >> 8);
    memcpy(out + size, bytes + at, length);
    size += length;
  }
  for (size_t i = 0; i < count; i++) a = (a + bytes[i]) % 65521, b = (b + a) % 65521;
  put_word(out + size, b << 16 | a);
  return size + 4;
}

static bool write_png(const cli_view_map *map, FILE *out) {
  static const unsigned char signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  unsigned char head[13] = {[8] = 16}; /* 16 bits, grey */
  unsigned char *rows = calloc(DATA_BYTES, 1), *stream = malloc(DATA_BYTES + DATA_BYTES / BLOCK_BYTES * 5 + 16);
  if (rows && stream) {
    put_word(head, EDGE);
    put_word(head + 4, EDGE);
    fill_rows(map, rows);
    fwrite(signature, 1, sizeof signature, out);
    write_chunk(out, "IHDR", head, sizeof head);
    write_chunk(out, "IDAT", stream, store(rows, DATA_BYTES, stream));
    write_chunk(out, "IEND", head, 0);
  }
  const bool is_written = rows && stream && !ferror(out);
  free(rows);
  free(stream);
  return is_written;
}

bool cli_view_map_save(const cli_view_map *map) {
  cli_text name = {0};
  cli_text_add(&name, "%s.new", map->path);
  if (!name.has_failed) unlink(cli_text_get(&name)); /* one that a killed view has left */
  FILE *out = name.has_failed ? NULL : fopen(cli_text_get(&name), "wbxe");
  bool is_written = out && write_png(map, out);
  if (out && fclose(out)) is_written = false;
  if (is_written && rename(cli_text_get(&name), map->path)) is_written = false;
  if (out && !is_written) unlink(cli_text_get(&name));
  cli_text_clear(&name);
  return is_written;
}
