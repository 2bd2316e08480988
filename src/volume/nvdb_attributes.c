/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/nvdb_attributes.h"

#include <string.h>

#include "core/alloc.h"

enum { BLIND_NAME_BYTES = 256 };

/* GridBlindMetaData of NanoVDB.h. */
typedef struct blind {
  int64_t offset; /* position of the data, counted from this struct */
  uint64_t count;
  uint32_t flags, semantic, data_class, data_type;
  char name[BLIND_NAME_BYTES];
} blind;

_Static_assert(sizeof(blind) == 288, "the fields of GridBlindMetaData, without padding");

/* Moves to a position of the grid that at least `size` bytes follow. */
static bool seek(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, int64_t at, uint64_t count) {
  if (at < 0 || (uint64_t)at > grid->bytes || count > grid->bytes - (uint64_t)at)
    np_vdb_bytes_fail(bytes, "its blind data stand at byte %lld of %llu", (long long)at,
                      (unsigned long long)grid->bytes);
  np_vdb_bytes_seek(bytes, begin + at);
  return !bytes->result;
}

static void read_text(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, int64_t at, const blind *found,
                      np_nvdb_attributes *out) {
  int64_t data = 0;
  if (__builtin_add_overflow(at, found->offset, &data)) data = -1;
  if (!seek(bytes, begin, grid, data, found->count)) return;
  out->text = np_alloc(bytes->context, found->count + 1, 1);
  if (!out->text) bytes->result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!out->text) return;
  out->size = found->count;
  np_vdb_bytes_read(bytes, out->text, found->count);
}

static void search(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, np_nvdb_attributes *out) {
  int64_t at = grid->blind_begin;
  if (!seek(bytes, begin, grid, at, grid->blind_count * (uint64_t)sizeof(blind))) return;
  for (uint32_t i = 0; i < grid->blind_count && !bytes->result && !out->text; i++, at += (int64_t)sizeof(blind)) {
    blind found;
    np_vdb_bytes_seek(bytes, begin + at);
    np_vdb_bytes_read(bytes, &found, sizeof found);
    if (!strncmp(found.name, NP_NVDB_ATTRIBUTES_NAME, sizeof found.name))
      read_text(bytes, begin, grid, at, &found, out);
  }
}

neph_result np_nvdb_attributes_read(np_nvdb_layout *layout, size_t index, np_nvdb_attributes *out_attributes) {
  const np_nvdb_grid *grid = &layout->grids[index];
  int64_t begin;
  *out_attributes = (np_nvdb_attributes){0};
  if (!grid->blind_count) return NEPH_OK;
  np_vdb_bytes *bytes = np_nvdb_layout_get_bytes(layout, index, &begin);
  if (!bytes) return layout->bytes->result ? layout->bytes->result : NEPH_ERROR_OUT_OF_MEMORY;
  bytes->grid = grid->name;
  search(bytes, begin, grid, out_attributes);
  bytes->grid = NULL;
  return bytes->result;
}

void np_nvdb_attributes_visit(const np_nvdb_attributes *attributes,
                              void (*visit)(void *user, const char *name, const char *text), void *user) {
  for (size_t at = 0; at < attributes->size;) {
    const char *name = attributes->text + at;
    at += strlen(name) + 1;
    if (at >= attributes->size) return;
    const char *text = attributes->text + at;
    at += strlen(text) + 1;
    visit(user, name, text);
  }
}

typedef struct attribute_search {
  const char *name, *text;
} attribute_search;

static void compare_name(void *user, const char *name, const char *text) {
  attribute_search *wanted = user;
  if (!strcmp(wanted->name, name)) wanted->text = text;
}

const char *np_nvdb_attributes_get(const np_nvdb_attributes *attributes, const char *name) {
  attribute_search wanted = {name, ""};
  np_nvdb_attributes_visit(attributes, compare_name, &wanted);
  return wanted.text;
}
