/* SPDX-License-Identifier: Apache-2.0 */
/* Formats of files that hold grids, a row of functions each. Inside the volume module only. */
#ifndef NP_VOLUME_VOLUME_FORMAT_H
#define NP_VOLUME_VOLUME_FORMAT_H

#include "volume/volume_file.h"

/* Called for each text of a grid's metadata. */
typedef void (*np_metadata_visit_fn)(void *user, const char *name, const char *text);

/* Functions that fail report why. */
struct np_volume_format {
  const char *ending;                /* ".vdb" */
  bool (*has_magic)(uint64_t magic); /* the first 8 bytes of a file */

  /* Opens `file->bytes` and sets `file->reader`; on failure that remains NULL. `monitor` may be NULL. */
  neph_result (*open)(np_volume_file *file, np_monitor *monitor);
  void (*close)(void *reader);

  size_t (*count)(const void *reader);
  void (*describe)(const void *reader, size_t index, np_vdb_grid_info *out_info);
  neph_result (*visit_metadata)(const np_volume_file *file, size_t index, np_metadata_visit_fn visit, void *user);

  /* Adds the requested leaves and tiles, in any order, to an initialised empty grid. */
  neph_result (*read)(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *grid,
                      uint64_t *out_tree_bytes);
  neph_result (*measure)(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size);

  /* Runs the library's checks of fog volumes: `visit` gets a message for each failed check. */
  neph_result (*diagnose)(const np_volume_file *file, size_t index, void (*visit)(void *user, const char *text),
                          void *user);
  neph_result (*mend)(const np_volume_file *file, np_vdb_mending *mendings, const char *path);
};

static inline np_vdb_sink np_vdb_sink_make(np_sparse_grid *grid) {
  return (np_vdb_sink){grid, np_sparse_grid_reserve, np_sparse_grid_add_leaf, np_sparse_grid_add_leaves,
                       np_sparse_grid_add_tile};
}

extern const np_volume_format np_vdb_format, np_nvdb_format, np_netcdf_format;

#endif
