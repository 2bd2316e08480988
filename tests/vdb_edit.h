/* SPDX-License-Identifier: Apache-2.0 */
/* Changes to the bytes of a .vdb file that keep it readable: what is longer or shorter than before moves all behind it,
 * and the offsets in the headers of the grids with it. Files with offsets alone, as saved to files (OpenVDB 10,
 * io/File.cc, io/GridDescriptor.cc). */
#ifndef NP_TEST_VDB_EDIT_H
#define NP_TEST_VDB_EDIT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { VDB_EDIT_GRIDS_MAX = 8, VDB_EDIT_ENTRIES_MAX = 24, VDB_EDIT_METADATA_AT = 8 + 4 + 8 + 1 + 36 };

/* A part of a file: of a text its letters, behind its length. */
typedef struct vdb_span {
  size_t at, count;
} vdb_span;

typedef struct vdb_entry {
  vdb_span name, value;
} vdb_entry;

typedef struct vdb_edit_grid {
  vdb_span name, type;
  size_t offsets; /* offsets of three positions: its header, its buffers, its end */
  vdb_entry entries[VDB_EDIT_ENTRIES_MAX];
  size_t entry_count;
  vdb_span transform; /* name of the map, with its length, and numbers */
  vdb_span topology, buffers;
} vdb_edit_grid;

typedef struct vdb_edit {
  uint8_t *data; /* owned */
  size_t size;
  size_t position; /* while it is parsed */
  bool is_broken;
  vdb_edit_grid grids[VDB_EDIT_GRIDS_MAX];
  size_t grid_count;
} vdb_edit;

/* ---- Reading ---- */

static inline bool vdb_edit_has(vdb_edit *e, size_t count) {
  e->is_broken = e->is_broken || count > e->size || e->position > e->size - count;
  return !e->is_broken;
}

static inline uint32_t vdb_edit_read_u32(vdb_edit *e) {
  uint32_t value = 0;
  if (vdb_edit_has(e, sizeof value)) memcpy(&value, e->data + e->position, sizeof value);
  e->position += sizeof value;
  return value;
}

static inline int64_t vdb_edit_get_i64(const vdb_edit *e, size_t at) {
  int64_t value;
  memcpy(&value, e->data + at, sizeof value);
  return value;
}

static inline vdb_span vdb_edit_skip(vdb_edit *e, size_t count) {
  const vdb_span span = {e->position, count};
  if (!vdb_edit_has(e, count)) return (vdb_span){0, 0};
  e->position += count;
  return span;
}

static inline vdb_span vdb_edit_read_text(vdb_edit *e) {
  const uint32_t length = vdb_edit_read_u32(e);
  return vdb_edit_skip(e, length);
}

static inline size_t vdb_edit_read_entries(vdb_edit *e, vdb_entry *entries) {
  const uint32_t count = vdb_edit_read_u32(e);
  size_t kept = 0;
  for (uint32_t i = 0; i < count && !e->is_broken; i++) {
    const vdb_span name = vdb_edit_read_text(e);
    (void)vdb_edit_read_text(e);
    const vdb_span value = vdb_edit_read_text(e); /* its length stands before it */
    if (entries && kept < VDB_EDIT_ENTRIES_MAX) entries[kept++] = (vdb_entry){name, value};
  }
  return kept;
}

static inline size_t vdb_edit_count_map(const vdb_edit *e, vdb_span name) {
  static const struct {
    const char *name;
    size_t numbers;
  } maps[] = {{"AffineMap", 16},
              {"UnitaryMap", 16},
              {"ScaleMap", 15},
              {"UniformScaleMap", 15},
              {"TranslationMap", 3},
              {"ScaleTranslateMap", 18},
              {"UniformScaleTranslateMap", 18}};
  for (size_t i = 0; i < sizeof maps / sizeof *maps; i++)
    if (strlen(maps[i].name) == name.count && !memcmp(maps[i].name, e->data + name.at, name.count))
      return maps[i].numbers * sizeof(double);
  return 0;
}

static inline vdb_span vdb_edit_read_transform(vdb_edit *e) {
  const size_t begin = e->position;
  vdb_span name = vdb_edit_read_text(e);
  if (name.count == strlen("NonlinearFrustumMap") && !memcmp(e->data + name.at, "NonlinearFrustumMap", name.count)) {
    (void)vdb_edit_skip(e, 8 * sizeof(double));
    name = vdb_edit_read_text(e);
  }
  const size_t count = vdb_edit_count_map(e, name);
  e->is_broken = e->is_broken || !count;
  (void)vdb_edit_skip(e, count);
  return (vdb_span){begin, e->position - begin};
}

static inline void vdb_edit_read_grid(vdb_edit *e, vdb_edit_grid *grid) {
  grid->name = vdb_edit_read_text(e);
  grid->type = vdb_edit_read_text(e);
  (void)vdb_edit_read_text(e);
  grid->offsets = e->position;
  if (!vdb_edit_has(e, 3 * sizeof(int64_t))) return;
  const size_t begin = (size_t)vdb_edit_get_i64(e, grid->offsets);
  const size_t buffers = (size_t)vdb_edit_get_i64(e, grid->offsets + 8);
  const size_t end = (size_t)vdb_edit_get_i64(e, grid->offsets + 16);
  e->position = begin;
  (void)vdb_edit_read_u32(e); /* its compression */
  grid->entry_count = vdb_edit_read_entries(e, grid->entries);
  grid->transform = vdb_edit_read_transform(e);
  e->is_broken = e->is_broken || e->position > buffers || buffers > end || end > e->size;
  grid->topology = (vdb_span){e->position, buffers - e->position};
  grid->buffers = (vdb_span){buffers, end - buffers};
  e->position = end;
}

/* Finds the parts again. False: it is no such file, or not any more. */
static inline bool vdb_edit_parse(vdb_edit *e) {
  e->is_broken = false;
  e->position = VDB_EDIT_METADATA_AT;
  (void)vdb_edit_read_entries(e, NULL);
  const uint32_t count = vdb_edit_read_u32(e);
  e->grid_count = count < VDB_EDIT_GRIDS_MAX ? count : VDB_EDIT_GRIDS_MAX;
  memset(e->grids, 0, sizeof e->grids);
  for (size_t i = 0; i < e->grid_count && !e->is_broken; i++) vdb_edit_read_grid(e, &e->grids[i]);
  return !e->is_broken;
}

/* ---- Writing ---- */

static inline void vdb_edit_move_offsets(vdb_edit *e, size_t at, ptrdiff_t shift) {
  for (size_t g = 0; g < e->grid_count; g++)
    for (size_t n = 0; n < 3; n++) {
      const size_t field = e->grids[g].offsets + 8 * n;
      int64_t value = vdb_edit_get_i64(e, field);
      if ((size_t)value > at) value += shift;
      memcpy(e->data + field, &value, sizeof value);
    }
}

/* Puts bytes in the place of a span, and finds the parts again. */
static inline bool vdb_edit_replace(vdb_edit *e, vdb_span span, const void *bytes, size_t count) {
  if (span.at + span.count > e->size) return false;
  const ptrdiff_t shift = (ptrdiff_t)count - (ptrdiff_t)span.count;
  uint8_t *data = malloc(e->size + count + 1);
  if (!data) return false;
  vdb_edit_move_offsets(e, span.at, shift);
  memcpy(data, e->data, span.at);
  memcpy(data + span.at, bytes, count);
  memcpy(data + span.at + count, e->data + span.at + span.count, e->size - span.at - span.count);
  e->size = (size_t)((ptrdiff_t)e->size + shift);
  free(e->data);
  e->data = data;
  return vdb_edit_parse(e);
}

/* The same of a text, with its length before it. */
static inline bool vdb_edit_replace_text(vdb_edit *e, vdb_span span, const char *text) {
  uint8_t bytes[4 + 256];
  const uint32_t length = (uint32_t)(strlen(text) < 256 ? strlen(text) : 256);
  memcpy(bytes, &length, 4);
  memcpy(bytes + 4, text, length);
  return span.at >= 4 && vdb_edit_replace(e, (vdb_span){span.at - 4, span.count + 4}, bytes, 4 + length);
}

static inline size_t vdb_edit_put_text(uint8_t *out, const char *text) {
  const uint32_t length = (uint32_t)strlen(text);
  memcpy(out, &length, 4);
  memcpy(out + 4, text, length);
  return 4 + length;
}

/* Adds a text to the file's own metadata, behind its header. */
static inline bool vdb_edit_add_file_text(vdb_edit *e, const char *name, const char *text) {
  uint8_t bytes[512];
  uint32_t count;
  memcpy(&count, e->data + VDB_EDIT_METADATA_AT, sizeof count);
  count++;
  memcpy(bytes, &count, sizeof count);
  size_t size = sizeof count;
  size += vdb_edit_put_text(bytes + size, name);
  size += vdb_edit_put_text(bytes + size, "string");
  size += vdb_edit_put_text(bytes + size, text);
  return vdb_edit_replace(e, (vdb_span){VDB_EDIT_METADATA_AT, sizeof count}, bytes, size);
}

/* Makes a grid one of a frustum: its index box, its taper, near over far, its depth in near widths, and the matrix
 * behind it, by rows of OpenVDB, which multiplies row vectors. */
static inline bool vdb_edit_set_frustum(vdb_edit *e, size_t grid, const double box_taper_depth[8],
                                        const double matrix[16]) {
  uint8_t bytes[512];
  size_t count = vdb_edit_put_text(bytes, "NonlinearFrustumMap");
  memcpy(bytes + count, box_taper_depth, 8 * sizeof(double));
  count += 8 * sizeof(double);
  count += vdb_edit_put_text(bytes + count, "AffineMap");
  memcpy(bytes + count, matrix, 16 * sizeof(double));
  return vdb_edit_replace(e, e->grids[grid].transform, bytes, count + 16 * sizeof(double));
}

#endif
