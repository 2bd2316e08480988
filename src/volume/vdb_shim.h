/* SPDX-License-Identifier: Apache-2.0 */
/* The door to OpenVDB: a module of C functions, loaded on first need. vdb_shim.cpp is the only C++ of nephos. */
#ifndef NP_VOLUME_VDB_SHIM_H
#define NP_VOLUME_VDB_SHIM_H

#include <stddef.h>
#include <stdint.h>

#include "volume/sparse_grid.h"

#ifdef __cplusplus
extern "C" {
#endif

#define NP_VDB_MODULE_VERSION 1u

typedef struct np_vdb_file np_vdb_file; /* an open file: its grids' headers */

/* One message for the caller to report; the shim never logs by itself. */
typedef struct np_vdb_error {
  neph_result result;
  char message[480];
} np_vdb_error;

typedef struct np_vdb_grid_info {
  const char *name;       /* valid while the file is open */
  const char *value_type; /* "float", "vec3s", "ptdataidx32", … */
  const char *grid_class; /* "fog volume", "level set", "unknown", … */
  const char *creator;
  int is_half_on_disk;
  int is_scalar; /* float, half or double: np_vdb_module.read takes it */
  int is_affine; /* transform is not a frustum */
  double index_to_world[3][4];
  uint64_t active_voxel_count; /* from the header's metadata; may lie until the grid is read */
} np_vdb_grid_info;

/* Asked during long work; non-zero stops it with NEPH_ERROR_CANCELLED. */
typedef int (*np_vdb_cancel_fn)(void *user);

typedef struct np_vdb_attribute {
  const char *name, *text; /* `text` NULL: a number */
  double number;
} np_vdb_attribute;

typedef struct np_vdb_write_grid {
  const np_sparse_grid *grid;
  int is_half;
  const np_vdb_attribute *attributes;
  size_t attribute_count;
} np_vdb_write_grid;

typedef struct np_vdb_module {
  uint32_t version; /* NP_VDB_MODULE_VERSION, checked before anything else is used */

  int (*open)(const char *path, np_vdb_file **out_file, np_vdb_error *error);
  void (*close)(np_vdb_file *file);
  size_t (*count)(const np_vdb_file *file);
  void (*describe)(const np_vdb_file *file, size_t index, np_vdb_grid_info *out_info);

  /* Visits a grid's metadata as text. */
  int (*visit_metadata)(const np_vdb_file *file, size_t index, void (*visit)(void *, const char *, const char *),
                        void *user, np_vdb_error *error);

  /* Reads one scalar grid into an initialised, empty np_sparse_grid (through its add functions). */
  int (*read)(np_vdb_file *file, size_t index, np_sparse_grid *grid, uint64_t *out_tree_bytes, np_vdb_cancel_fn cancel,
              void *cancel_user, np_vdb_error *error);

  /* Writes grids to `path`, which is a temporary name: the caller renames it. */
  int (*write)(const char *path, const np_vdb_write_grid *grids, size_t count, unsigned thread_count,
               np_vdb_cancel_fn cancel, void *cancel_user, np_vdb_error *error);

  /* OpenVDB's own trilinear BoxSampler at index positions, for tests. */
  int (*sample)(const np_sparse_grid *grid, size_t count, const double *positions, float *out_values,
                np_vdb_error *error);

  /* Holds TBB to a number of threads for as long as the handle lives. */
  void *(*limit_threads)(unsigned thread_count);
  void (*unlimit_threads)(void *handle);
} np_vdb_module;

/* The only exported symbol of nephos_vdb.so. */
const np_vdb_module *nephos_vdb_module(void);

#ifdef __cplusplus
}
#endif

#endif
