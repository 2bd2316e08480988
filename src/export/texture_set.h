/* SPDX-License-Identifier: Apache-2.0 */
/* The textures of one export: files that appear together, and the JSON file that describes them. */
#ifndef NP_EXPORT_TEXTURE_SET_H
#define NP_EXPORT_TEXTURE_SET_H

#include "export/texture.h"

/* A texture whose file is written, under its temporary name until the set is committed. */
typedef struct np_texture_entry {
  char *name, *path;
  const char *texels;
  unsigned size[3];
  uint64_t byte_count;
  np_file_write write; /* its names are NULL in a dry run */
} np_texture_entry;

typedef struct np_texture_set {
  neph_context *context; /* context, folder, description and monitor are borrowed */
  const char *folder;
  const neph_textures_desc *desc;
  np_monitor *monitor;
  np_json *json; /* the JSON file; its array of textures is open, then its array of clouds */
  size_t count;
  np_texture_entry *entries;
} np_texture_set;

/* Starts a set. np_texture_set_end ends it in any case. */
neph_result np_texture_set_begin(np_texture_set *set);

/* Writes a texture; in a dry run notes it alone. */
neph_result np_texture_set_add(np_texture_set *set, const np_texture *texture);

/* Writes the JSON file, gives all files their names and reports them. */
neph_result np_texture_set_commit(np_texture_set *set);

/* Removes the files of a set that was not committed. */
void np_texture_set_end(np_texture_set *set);

#endif
