/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_cover.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"

enum { LIST_SIZE = 1200 };

typedef struct cover {
  neph_context *context;
  const np_merge_part *parts; /* sorted by their first sample */
  size_t count;
  unsigned tile_count; /* largest tile count stated by a part */
  char missing[LIST_SIZE];
  size_t length;
} cover;

/* Rows [begin, end) that the same parts have. */
typedef struct band {
  int begin, end;
} band;

static int compare_samples(const void *a, const void *b) {
  const np_merge_part *p = a, *q = b;
  if (p->header.sample_begin != q->header.sample_begin) return p->header.sample_begin < q->header.sample_begin ? -1 : 1;
  return p->header.min[1] < q->header.min[1] ? -1 : p->header.min[1] > q->header.min[1];
}

static int get_tile_begin(const cover *c, unsigned tile) {
  return np_part_get_tile_row(&c->parts[0].header, tile, c->tile_count);
}

static void name_band(const cover *c, band rows, char *out, size_t size) {
  for (unsigned tile = 0; tile < c->tile_count && c->tile_count > 1; tile++)
    if (get_tile_begin(c, tile) == rows.begin && get_tile_begin(c, tile + 1) == rows.end) {
      np_print(out, size, "tile %u/%u", tile + 1, c->tile_count);
      return;
    }
  np_print(out, size, "rows %d to %d", rows.begin, rows.end - 1);
}

/* Notes that a band lacks samples [begin, end), or, where both are 0, all. */
static void note_missing(cover *c, band rows, uint32_t begin, uint32_t end) {
  char name[48], samples[48] = "";
  name_band(c, rows, name, sizeof name);
  if (end > 0) np_print(samples, sizeof samples, ", samples %u-%u", begin, end);
  if (c->length + strlen(name) + strlen(samples) + 8 > sizeof c->missing) return;
  c->length +=
      np_print(c->missing + c->length, sizeof c->missing - c->length, "%s%s%s", c->length ? "; " : "", name, samples);
}

static bool has_rows(const np_merge_part *part, band rows) {
  return part->header.min[1] <= rows.begin && part->header.max[1] >= rows.end;
}

static neph_result fail_overlap(const cover *c, const np_merge_part *part, const np_merge_part *before, band rows) {
  char name[48];
  name_band(c, rows, name, sizeof name);
  return np_fail(c->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s and %s overlap in %s: give each tile and each range of samples once", before->path, part->path,
                 name);
}

static neph_result check_band(cover *c, band rows) {
  assert(rows.begin < rows.end);
  const np_merge_part *before = NULL;
  uint32_t next = 0, samples = 0;
  for (size_t i = 0; i < c->count; i++) {
    const np_merge_part *part = &c->parts[i];
    if (!has_rows(part, rows)) continue;
    if (before && (part->header.is_complete || before->header.is_complete || part->header.sample_begin < next))
      return fail_overlap(c, part, before, rows);
    samples = part->header.sample_count;
    if (!part->header.is_complete && part->header.sample_begin > next)
      note_missing(c, rows, next, part->header.sample_begin);
    next = part->header.sample_end;
    before = part;
  }
  if (!before) note_missing(c, rows, 0, 0);
  if (before && !before->header.is_complete && next < samples) note_missing(c, rows, next, samples);
  return NEPH_OK;
}

static int compare_rows(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

/* Bands between all the edges of parts and tiles. */
static neph_result check_bands(cover *c, int *edges) {
  size_t count = 0;
  for (size_t i = 0; i < c->count; i++) {
    edges[count++] = c->parts[i].header.min[1];
    edges[count++] = c->parts[i].header.max[1];
  }
  for (unsigned tile = 0; tile <= c->tile_count; tile++) edges[count++] = get_tile_begin(c, tile);
  qsort(edges, count, sizeof *edges, compare_rows);
  neph_result result = NEPH_OK;
  for (size_t i = 0; i + 1 < count && !result; i++)
    if (edges[i] < edges[i + 1]) result = check_band(c, (band){edges[i], edges[i + 1]});
  return result;
}

neph_result np_merge_cover_check(np_merge_part *parts, size_t count) {
  assert(count > 0);
  qsort(parts, count, sizeof *parts, compare_samples);
  cover c = {.context = parts[0].context, .parts = parts, .count = count, .tile_count = 1};
  for (size_t i = 0; i < count; i++)
    if (parts[i].header.tile_count > c.tile_count) c.tile_count = parts[i].header.tile_count;
  int *edges = np_alloc(c.context, 2 * count + c.tile_count + 1, sizeof *edges);
  if (!edges) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = check_bands(&c, edges);
  np_alloc_free(c.context, edges);
  if (result || !c.length) return result;
  return np_fail(c.context, NEPH_ERROR_NOT_FOUND, "parts of the picture are missing: %s", c.missing);
}
