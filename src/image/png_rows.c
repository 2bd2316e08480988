/* SPDX-License-Identifier: Apache-2.0 */
/* Rows are filtered as the PNG specification describes (ISO/IEC 15948, section 9), each by the filter with the least
 * sum of absolute values (its section 12.8). Strips of rows are compressed as parts of one zlib stream: each takes the
 * data before it as its dictionary, and ends on a whole byte.
 */
#include "image/png_rows.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "core/alloc.h"
#include "core/parallel.h"

enum {
  STRIP_BYTES = 1 << 16, /* about as many of the rows in a strip */
  WINDOW_BYTES = 1 << 15,
  HEADER_BYTES = 2,   /* before the first strip */
  CHECKSUM_BYTES = 4, /* after the last strip */
  LEVEL = 6,
  MEMORY_LEVEL = 8
};

static const uint8_t zlib_header[HEADER_BYTES] = {0x78, 0x9c}; /* deflate with a window of 32 kB, RFC 1950 */

typedef enum filter { FILTER_NONE, FILTER_SUB, FILTER_UP, FILTER_AVERAGE, FILTER_PAETH, FILTER_COUNT } filter;

typedef struct png_packing {
  const np_png_rows *rows;
  size_t line_bytes, strip_rows, strip_count; /* a line is a row after its filter's number */
  uint8_t *lines;
  uint8_t *scratch; /* two rows, then a line for each filter; each thread has its own */
  size_t scratch_bytes;
  np_png_strip *strips;
  uint32_t *checksums; /* Adler's, of each strip's lines */
  neph_context *context;
} png_packing;

/* ---- Filters ---- */

static inline uint8_t predict_paeth(int left, int up, int corner) {
  const int along = abs(up - corner), down = abs(left - corner), both = abs(left + up - 2 * corner);
  return (uint8_t)(along <= down && along <= both ? left : down <= both ? up : corner);
}

static inline uint8_t predict(filter f, uint8_t left, uint8_t up, uint8_t corner) {
  switch (f) {
  case FILTER_SUB:
    return left;
  case FILTER_UP:
    return up;
  case FILTER_AVERAGE:
    return (uint8_t)((left + up) / 2);
  case FILTER_PAETH:
    return predict_paeth(left, up, corner);
  case FILTER_NONE:
  case FILTER_COUNT:
    break;
  }
  return 0;
}

/* Filters a row, given the one above it; returns the sum of the absolute values of what is left. */
static inline uint32_t apply(filter f, const np_png_rows *rows, const uint8_t *row, const uint8_t *above,
                             uint8_t *out_line) {
  uint32_t sum = 0;
  *out_line++ = (uint8_t)f;
  for (size_t i = 0; i < rows->row_bytes; i++) {
    const bool has_left = i >= rows->pixel_bytes;
    const uint8_t left = has_left ? row[i - rows->pixel_bytes] : 0,
                  corner = has_left ? above[i - rows->pixel_bytes] : 0;
    out_line[i] = (uint8_t)(row[i] - predict(f, left, above[i], corner));
    sum += (uint32_t)abs((int8_t)out_line[i]);
  }
  return sum;
}

/* Each filter's loop is compiled apart. */
static uint32_t filter_row(filter f, const np_png_rows *rows, const uint8_t *row, const uint8_t *above, uint8_t *out) {
  switch (f) {
  case FILTER_SUB:
    return apply(FILTER_SUB, rows, row, above, out);
  case FILTER_UP:
    return apply(FILTER_UP, rows, row, above, out);
  case FILTER_AVERAGE:
    return apply(FILTER_AVERAGE, rows, row, above, out);
  case FILTER_PAETH:
    return apply(FILTER_PAETH, rows, row, above, out);
  case FILTER_NONE:
  case FILTER_COUNT:
    break;
  }
  return apply(FILTER_NONE, rows, row, above, out);
}

static void fill_line(const png_packing *p, const uint8_t *row, const uint8_t *above, uint8_t *tries,
                      uint8_t *out_line) {
  uint32_t least = UINT32_MAX;
  unsigned best = 0;
  for (unsigned f = 0; f < FILTER_COUNT; f++) {
    const uint32_t sum = filter_row((filter)f, p->rows, row, above, tries + f * p->line_bytes);
    if (sum >= least) continue;
    least = sum;
    best = f;
  }
  memcpy(out_line, tries + best * p->line_bytes, p->line_bytes);
}

static size_t get_strip_end(const png_packing *p, size_t strip) {
  const size_t end = (strip + 1) * p->strip_rows;
  return end < p->rows->height ? end : p->rows->height;
}

static neph_result fill_strips(void *user, size_t begin, size_t end, unsigned thread) {
  const png_packing *p = user;
  const size_t bytes = p->rows->row_bytes;
  uint8_t *above = p->scratch + thread * p->scratch_bytes, *row = above + bytes, *const tries = row + bytes;
  for (size_t strip = begin; strip < end; strip++) {
    const size_t first = strip * p->strip_rows;
    memset(above, 0, bytes);
    if (first) p->rows->pack(p->rows->user, first - 1, above);
    for (size_t y = first; y < get_strip_end(p, strip); y++) {
      p->rows->pack(p->rows->user, y, row);
      fill_line(p, row, above, tries, p->lines + y * p->line_bytes);
      uint8_t *const next = above;
      above = row;
      row = next;
    }
  }
  return NEPH_OK;
}

/* ---- Strips ---- */

static neph_result fail_compression(const png_packing *p) {
  return np_fail(p->context, NEPH_ERROR_OUT_OF_MEMORY, "out of memory: zlib cannot compress a picture");
}

static neph_result deflate_lines(z_stream *z, const png_packing *p, size_t strip, np_png_strip *out) {
  const size_t begin = strip * p->strip_rows * p->line_bytes, end = get_strip_end(p, strip) * p->line_bytes;
  const size_t window = begin < WINDOW_BYTES ? begin : WINDOW_BYTES;
  const bool is_last = strip + 1 == p->strip_count;
  if (window && deflateSetDictionary(z, p->lines + begin - window, (uInt)window) != Z_OK) return fail_compression(p);
  out->size = strip ? 0 : HEADER_BYTES;
  const size_t room = out->size + deflateBound(z, (uLong)(end - begin)) + 16 + CHECKSUM_BYTES;
  out->bytes = np_alloc(p->context, room, 1);
  if (!out->bytes) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(out->bytes, zlib_header, out->size);
  z->next_in = p->lines + begin;
  z->avail_in = (uInt)(end - begin);
  z->next_out = out->bytes + out->size;
  z->avail_out = (uInt)(room - out->size - CHECKSUM_BYTES);
  const int code = deflate(z, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  out->size = (size_t)(z->next_out - out->bytes);
  p->checksums[strip] = (uint32_t)adler32(1, p->lines + begin, (uInt)(end - begin));
  assert(code == (is_last ? Z_STREAM_END : Z_OK) && z->avail_in == 0 && z->avail_out > 0);
  return code == (is_last ? Z_STREAM_END : Z_OK) ? NEPH_OK : fail_compression(p);
}

static neph_result compress_strips(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const png_packing *p = user;
  neph_result result = NEPH_OK;
  for (size_t strip = begin; strip < end && !result; strip++) {
    z_stream z = {0};
    if (deflateInit2(&z, LEVEL, Z_DEFLATED, -MAX_WBITS, MEMORY_LEVEL, Z_FILTERED) != Z_OK)
      return fail_compression(p);
    result = deflate_lines(&z, p, strip, &p->strips[strip]);
    (void)deflateEnd(&z);
  }
  return result;
}

/* Appends the checksum of all lines to the last strip, high byte first. */
static void append_checksum(const png_packing *p) {
  uLong sum = 1;
  for (size_t strip = 0; strip < p->strip_count; strip++) {
    const size_t rows = get_strip_end(p, strip) - strip * p->strip_rows;
    sum = adler32_combine(sum, p->checksums[strip], (z_off_t)(rows * p->line_bytes));
  }
  np_png_strip *last = &p->strips[p->strip_count - 1];
  for (int shift = 24; shift >= 0; shift -= 8) last->bytes[last->size++] = (uint8_t)(sum >> shift);
}

void np_png_strips_free(neph_context *context, np_png_strip *strips, size_t count) {
  for (size_t i = 0; strips && i < count; i++) np_alloc_free(context, strips[i].bytes);
  np_alloc_free(context, strips);
}

neph_result np_png_rows_compress(neph_context *context, const np_png_rows *rows, np_png_strip **out_strips,
                                 size_t *out_count) {
  png_packing p = {.rows = rows, .line_bytes = rows->row_bytes + 1, .context = context};
  p.strip_rows = STRIP_BYTES / p.line_bytes + 1;
  p.strip_count = (rows->height + p.strip_rows - 1) / p.strip_rows;
  p.scratch_bytes = 2 * rows->row_bytes + FILTER_COUNT * p.line_bytes;
  p.lines = np_alloc(context, rows->height, p.line_bytes);
  p.scratch = np_alloc(context, neph_context_get_thread_count(context), p.scratch_bytes);
  p.strips = np_alloc(context, p.strip_count, sizeof *p.strips);
  p.checksums = np_alloc(context, p.strip_count, sizeof *p.checksums);
  neph_result result = p.lines && p.scratch && p.strips && p.checksums ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_parallel_for(context, NULL, p.strip_count, 1, fill_strips, &p);
  if (!result) result = np_parallel_for(context, NULL, p.strip_count, 1, compress_strips, &p);
  if (!result) append_checksum(&p);
  np_alloc_free(context, p.checksums);
  np_alloc_free(context, p.scratch);
  np_alloc_free(context, p.lines);
  if (result) np_png_strips_free(context, p.strips, p.strip_count);
  *out_strips = result ? NULL : p.strips;
  *out_count = result ? 0 : p.strip_count;
  return result;
}
