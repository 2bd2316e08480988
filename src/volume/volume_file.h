/* SPDX-License-Identifier: Apache-2.0 */
/* A .vdb file open for reading, and the checks that its grids must pass. Inside the volume module only. */
#ifndef NP_VOLUME_VOLUME_FILE_H
#define NP_VOLUME_VOLUME_FILE_H

#include "volume/value_tally.h"
#include "volume/vdb_layout.h"
#include "volume/volume_private.h"

enum { NP_VOLUME_GRIDS_MAX = 16 };

typedef struct np_volume_file {
  neph_context *context;
  const char *path; /* borrowed */
  const np_vdb_module *module;
  np_vdb_layout *layout; /* what `vdb` reads through */
  np_vdb_file *vdb;
} np_volume_file;

/* Opens a file and reads what its grids are. `monitor` may be NULL; else it must live until the file is closed. */
neph_result np_volume_file_open(neph_context *context, const char *path, np_monitor *monitor, np_volume_file *out_file);
void np_volume_file_close(np_volume_file *file); /* a zeroed file is allowed */

static inline np_vdb_grid_info np_volume_file_describe(const np_volume_file *file, size_t index) {
  np_vdb_grid_info info;
  file->module->describe(file->vdb, index, &info);
  return info;
}

/* Reads a scalar grid, sorted. The caller clears the grid, whatever the outcome. */
neph_result np_volume_file_read(const np_volume_file *file, size_t index, np_sparse_grid *out_grid,
                                uint64_t *out_tree_bytes);

/* The same of one component of a vector, 0 to 2, or, for 0, of a scalar. */
neph_result np_volume_file_read_component(const np_volume_file *file, size_t index, int component,
                                          np_sparse_grid *out_grid, uint64_t *out_tree_bytes);

/* Grids that a density is read from. */
typedef struct np_volume_choice {
  size_t indices[NP_VOLUME_GRIDS_MAX], count; /* of several, the sum */
  double level_set_voxels;                    /* depth at which a level set is 1 */
} np_volume_choice;

/* The same of a density: whole numbers and marks become floats, level sets fog; grids of a sum whose lattice is not the
 * first one's are resampled. Grids of a frustum stay in it: np_sparse_grid.frustum. */
neph_result np_volume_file_read_density(const np_volume_file *file, const np_volume_choice *choice,
                                        np_sparse_grid *out_grid, uint64_t *out_tree_bytes);

/* Searches the grids of a vector's three components; `name` NULL: the usual ones. */
bool np_volume_file_search_vector(const np_volume_file *file, np_vector_role role, const char *name,
                                  size_t out_grids[3]);

/* Reports what the module said, under the file's name. */
neph_result np_volume_file_fail(const np_volume_file *file, const np_vdb_error *error);

/* Checks the values of a grid just read by a rule, and repairs what is rounding, or, where the policy says so, what is
 * not: NaN, infinite, and of a cloud negative. Fails or warns with counts and the first voxel. */
neph_result np_volume_import_values(neph_context *context, const char *path, np_sparse_grid *grid, np_value_rule rule,
                                    neph_import_policy policy, np_monitor *monitor);

/* Checks that a grid just read is 0 where it ends, and makes it so where the policy says so. */
neph_result np_volume_import_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                        neph_import_policy policy);

/* The same of a field or a vector, which may end in any finite number. */
neph_result np_volume_import_finite_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                               neph_import_policy policy);

/* Puts the values of a density, which are finite and not negative, through a ramp. */
neph_result np_volume_apply_ramp(neph_context *context, np_sparse_grid *grid, const neph_volume_ramp *ramp,
                                 np_monitor *monitor);

#endif
