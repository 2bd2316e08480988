/* SPDX-License-Identifier: Apache-2.0 */
/* A file of grids open for reading, and the validation of its grids. Inside the volume module only. */
#ifndef NP_VOLUME_VOLUME_FILE_H
#define NP_VOLUME_VOLUME_FILE_H

#include "volume/value_tally.h"
#include "volume/vdb_bytes.h"
#include "volume/volume_private.h"

enum { NP_VOLUME_GRIDS_MAX = 16 };

typedef struct np_volume_format np_volume_format; /* volume_format.h */

typedef struct np_volume_file {
  neph_context *context;
  const char *path;                  /* borrowed */
  np_vdb_bytes *bytes;               /* owned; bytes of the file */
  const neph_volume_load_desc *desc; /* borrowed; NULL: the defaults */
  const np_volume_format *format;
  void *reader; /* the open file, of a type of the format */
} np_volume_file;

/* Opens a file and reads the headers of its grids. `desc`, which may be NULL, says how a model's field is read;
 * `monitor` may be NULL. Else both must outlive the open file. */
neph_result np_volume_file_open(neph_context *context, const char *path, const neph_volume_load_desc *desc,
                                np_monitor *monitor, np_volume_file *out_file);

/* Opens the bytes of a file, called `name` in messages, which must stay until it is closed. */
neph_result np_volume_file_open_memory(neph_context *context, const char *name, const void *memory, size_t size,
                                       const neph_volume_load_desc *desc, np_monitor *monitor,
                                       np_volume_file *out_file);
void np_volume_file_close(np_volume_file *file); /* a zeroed file is allowed */

size_t np_volume_file_count(const np_volume_file *file);
np_vdb_grid_info np_volume_file_describe(const np_volume_file *file, size_t index);

/* Visits a grid's metadata as text. */
neph_result np_volume_file_visit_metadata(const np_volume_file *file, size_t index,
                                          void (*visit)(void *user, const char *name, const char *text), void *user);

/* Reads a scalar grid, sorted. The caller clears the grid, whatever the outcome. */
neph_result np_volume_file_read(const np_volume_file *file, size_t index, np_sparse_grid *out_grid,
                                uint64_t *out_tree_bytes);

/* Reads one component, 0 to 2, of a vector grid, or, for 0, a scalar grid; sorted. The caller clears the grid. */
neph_result np_volume_file_read_component(const np_volume_file *file, size_t index, int component,
                                          np_sparse_grid *out_grid, uint64_t *out_tree_bytes);

/* Grids that hold a density. */
typedef struct np_volume_choice {
  size_t indices[NP_VOLUME_GRIDS_MAX], count; /* several are summed */
  double level_set_voxels;                    /* depth below a level set's surface at which density reaches 1 */
} np_volume_choice;

/* Reads a density, sorted: integers and masks become floats, level sets become fog, and the grids of a sum are
 * resampled to the lattice of the first. Frustum grids are not resampled (np_sparse_grid.frustum). The caller clears
 * the grid. */
neph_result np_volume_file_read_density(const np_volume_file *file, const np_volume_choice *choice,
                                        np_sparse_grid *out_grid, uint64_t *out_tree_bytes);

/* Searches the grids of a vector's three components; `name` NULL: the usual names. */
bool np_volume_file_search_vector(const np_volume_file *file, np_vector_role role, const char *name,
                                  size_t out_grids[3]);

/* Reads any grid's topology, and returns its size. */
neph_result np_volume_file_measure(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size);

/* Runs the library's checks of fog volumes on a grid: `visit` gets a message for each failed check. */
neph_result np_volume_file_diagnose(const np_volume_file *file, size_t index,
                                    void (*visit)(void *user, const char *text), void *user);

/* Writes all grids and metadata to `path`, a temporary name, mended as `mendings` say, one for each grid, which get
 * their outcomes. */
neph_result np_volume_file_mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path);

/* Checks the values of a loaded grid by a rule. Rounding errors are repaired; NaN, infinity and negative densities are
 * repaired or refused, by the policy. Messages state counts and the first voxel. */
neph_result np_volume_import_values(neph_context *context, const char *path, np_sparse_grid *grid, np_value_rule rule,
                                    neph_import_policy policy, np_monitor *monitor);

/* Checks that the background of a loaded density is 0, and sets it to 0 if the policy allows it. */
neph_result np_volume_import_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                        neph_import_policy policy);

/* Checks that the background of a field or vector is finite, and sets it to 0 if the policy allows it. */
neph_result np_volume_import_finite_background(neph_context *context, const char *path, np_sparse_grid *grid,
                                               neph_import_policy policy);

/* Applies a ramp to the values of a density, which are finite and not negative. */
neph_result np_volume_apply_ramp(neph_context *context, np_sparse_grid *grid, const neph_volume_ramp *ramp,
                                 np_monitor *monitor);

#endif
