/* SPDX-License-Identifier: Apache-2.0 */
/* The tree of a grid in a .nvdb file. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_TREE_H
#define NP_VOLUME_NVDB_TREE_H

#include "volume/nvdb_layout.h"
#include "volume/sparse_grid.h"

/* Adds one component of a grid, which begins at a position of `bytes`, to a sparse grid: background, leaves, and tiles
 * that differ from an inactive background. Its type must be known, and no NP_NVDB_OTHER. A failure is reported.
 * `monitor` may be NULL. */
neph_result np_nvdb_tree_read(np_vdb_bytes *bytes, int64_t begin, const np_nvdb_grid *grid, int component,
                              np_monitor *monitor, np_sparse_grid *out_grid);

#endif
