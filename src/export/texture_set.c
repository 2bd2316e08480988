/* SPDX-License-Identifier: Apache-2.0 */
#include "export/texture_set.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"

static const char json_name[] = "textures.json";

neph_result np_texture_set_begin(np_texture_set *set) {
  set->json = np_json_create(set->context);
  return set->json ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Adds an entry, whose file is open for writing unless the run is dry. */
static neph_result add_entry(np_texture_set *set, const char *name, const char *file, np_texture_entry **out_entry) {
  neph_context *context = set->context;
  np_texture_entry *grown = np_alloc_resize(context, set->entries, set->count + 1, sizeof *grown);
  if (!grown) return NEPH_ERROR_OUT_OF_MEMORY;
  set->entries = grown;
  np_texture_entry *entry = *out_entry = &grown[set->count++];
  *entry = (np_texture_entry){.name = np_alloc_text(context, name)};
  const size_t length = strlen(set->folder);
  entry->path =
      np_alloc_printf(context, "%s%s%s", set->folder, length && set->folder[length - 1] != '/' ? "/" : "", file);
  if (!entry->name || !entry->path) return NEPH_ERROR_OUT_OF_MEMORY;
  return set->desc->is_dry_run ? NEPH_OK : np_file_write_begin(context, entry->path, &entry->write);
}

neph_result np_texture_set_add(np_texture_set *set, const np_texture *texture) {
  np_texture_entry *entry;
  np_texture_range range;
  const char *ending = set->desc->format == NEPH_TEXTURE_RAW ? "raw" : "ktx2";
  char *file = np_alloc_printf(set->context, "%s.%s", texture->name, ending);
  neph_result result = file ? add_entry(set, texture->name, file, &entry) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) {
    entry->texels = np_texel_format_get(texture->texel)->name;
    memcpy(entry->size, texture->size, sizeof entry->size);
    entry->byte_count = np_texture_count_bytes(texture);
  }
  if (!result && !set->desc->is_dry_run) {
    result = np_texture_write_file(texture, set->desc->format, &entry->write, set->monitor, &range);
    if (!result) np_texture_describe(texture, file, &range, set->json);
  }
  np_alloc_free(set->context, file);
  return result;
}

/* ---- Together ---- */

static neph_result add_json(np_texture_set *set) {
  np_texture_entry *entry;
  char *text = NULL;
  neph_result result = add_entry(set, json_name, json_name, &entry);
  if (result) return result;
  entry->texels = "JSON";
  if (set->desc->is_dry_run) return NEPH_OK;
  result = np_json_finish(set->json, &text);
  set->json = NULL;
  if (result) return result;
  entry->byte_count = strlen(text);
  FILE *out = fopen(entry->write.temporary, "we");
  bool is_written = out && fputs(text, out) >= 0;
  if (out && fclose(out)) is_written = false;
  const int error = errno;
  np_alloc_free(set->context, text);
  return is_written ? NEPH_OK
                    : np_fail(set->context, NEPH_ERROR_IO, "%s: cannot be written: %s", entry->path, strerror(error));
}

static void report(const np_texture_set *set) {
  for (size_t i = 0; i < set->count && set->desc->report; i++) {
    const np_texture_entry *entry = &set->entries[i];
    const neph_texture texture = {.name = entry->name,
                                  .path = entry->path,
                                  .texels = entry->texels,
                                  .size = {entry->size[0], entry->size[1], entry->size[2]},
                                  .byte_count = entry->byte_count};
    set->desc->report(set->desc->report_user, &texture);
  }
}

neph_result np_texture_set_commit(np_texture_set *set) {
  neph_result result = add_json(set);
  for (size_t i = 0; i < set->count && !result && !set->desc->is_dry_run; i++)
    result = np_file_write_commit(&set->entries[i].write);
  if (!result) report(set);
  return result;
}

void np_texture_set_end(np_texture_set *set) {
  for (size_t i = 0; i < set->count; i++) {
    np_texture_entry *entry = &set->entries[i];
    if (entry->write.temporary) np_file_write_abandon(&entry->write);
    np_alloc_free(set->context, entry->name);
    np_alloc_free(set->context, entry->path);
  }
  np_alloc_free(set->context, set->entries);
  np_json_destroy(set->json);
  *set = (np_texture_set){0};
}
